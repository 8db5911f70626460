#include "apps/bake/agreement.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string_view>

#include "base/error.h"

namespace prt {

namespace {

// First character of a handed-in verdict.
constexpr char kFine = '+';
constexpr char kUserError = 'u';
constexpr char kFailure = 'f';

constexpr std::array<std::string_view, 5> kIsas{"sse2", "sse4.2", "avx", "avx2", "avx512"};

std::size_t level(const std::string& isa) {
  return static_cast<std::size_t>(std::ranges::find(kIsas, isa) - kIsas.begin());
}

std::string verdict_of(const std::function<void()>& step) {
  try {
    step();
  } catch (const UserError& e) {
    return kUserError + std::string(e.what());
  } catch (const std::exception& e) {
    return kFailure + std::string(e.what());
  }
  return std::string(1, kFine);
}

}  // namespace

void do_together(Ranks& ranks, const std::function<void()>& step) {
  for (const std::string& verdict : ranks.gather_all(verdict_of(step))) {
    if (verdict[0] == kUserError) throw UserError(verdict.substr(1));
    if (verdict[0] == kFailure) throw std::runtime_error(verdict.substr(1));
  }
}

void expect_same(Ranks& ranks, const std::string& text, const std::string& what) {
  const std::vector<std::string> all = ranks.gather_all(text);
  if (std::ranges::adjacent_find(all, std::not_equal_to<>()) == all.end()) return;
  throw UserError("the ranks see " + what +
                  "; give all machines the same program, files and command line");
}

std::string lowest_isa(const std::vector<std::string>& isas) {
  return *std::ranges::min_element(isas, {}, level);
}

bool can_run(const std::string& best, const std::string& isa) { return level(isa) <= level(best); }

}  // namespace prt
