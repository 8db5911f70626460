// A file system that all ranks share: each gets the same rate, at most what one rank can take.
#pragma once

#include <cstdint>
#include <queue>
#include <utility>
#include <vector>

namespace prt::scaling {

class SharedDisk {
 public:
  /// Bytes per second.
  SharedDisk(double per_rank, double in_total);

  void start(int worker, double bytes, double now);
  /// When the next transfer ends if no other begins; infinity while none runs.
  [[nodiscard]] double next_end() const;
  /// Ends that transfer; returns its worker.
  int finish_next();

 private:
  struct Transfer {
    double end;  ///< in served bytes
    std::uint64_t order;
    int worker;
    bool operator>(const Transfer& other) const {
      return end != other.end ? end > other.end : order > other.order;
    }
  };
  [[nodiscard]] double rate() const;
  void advance(double now);

  double per_rank_;
  double in_total_;
  double now_ = 0.0;
  double served_ = 0.0;  ///< bytes that every transfer running all the time would have got
  std::uint64_t order_ = 0;
  std::priority_queue<Transfer, std::vector<Transfer>, std::greater<>> running_;
};

}  // namespace prt::scaling
