#include "jobs/ranks.h"

#include <cstdlib>

namespace prt {

namespace {

class SingleRank : public Ranks {
 public:
  [[nodiscard]] int rank() const override { return 0; }
  [[nodiscard]] int size() const override { return 1; }
  [[nodiscard]] int node_rank() const override { return 0; }
  [[nodiscard]] int node_size() const override { return 1; }
  std::string broadcast(std::string text) override { return text; }
  std::vector<std::string> gather_all(const std::string& text) override { return {text}; }
  Link& link() override { return link_; }
  void finish() override {}
  [[noreturn]] void abort(int code) override { std::_Exit(code); }
  [[noreturn]] void abort_without(const std::vector<int>&, int code) override { abort(code); }

 private:
  NoLink link_;
};

}  // namespace

std::unique_ptr<Ranks> make_single_rank() { return std::make_unique<SingleRank>(); }

}  // namespace prt
