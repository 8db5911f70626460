#include "scaling/shared_disk.h"

#include <algorithm>
#include <limits>

namespace prt::scaling {

SharedDisk::SharedDisk(double per_rank, double in_total)
    : per_rank_(per_rank), in_total_(in_total) {}

double SharedDisk::rate() const {
  return std::min(per_rank_, in_total_ / static_cast<double>(running_.size()));
}

void SharedDisk::advance(double now) {
  if (!running_.empty()) served_ += rate() * (now - now_);
  now_ = now;
}

void SharedDisk::start(int worker, double bytes, double now) {
  advance(now);
  running_.push({served_ + bytes, order_++, worker});
}

double SharedDisk::next_end() const {
  if (running_.empty()) return std::numeric_limits<double>::infinity();
  return now_ + std::max(0.0, running_.top().end - served_) / rate();
}

int SharedDisk::finish_next() {
  const Transfer ended = running_.top();
  now_ = next_end();
  served_ = std::max(served_, ended.end);
  running_.pop();
  return ended.worker;
}

}  // namespace prt::scaling
