#include "apps/bake/input_cache.h"

namespace prt {

namespace {

std::size_t size_of(const Artifact& artifact) {
  std::size_t bytes = 0;
  for (const auto& [name, dataset] : artifact.datasets) bytes += dataset.bytes.size();
  return bytes;
}

}  // namespace

InputCache::InputCache(const ArtifactStore& store, std::size_t most_bytes)
    : store_(store), most_bytes_(most_bytes) {}

std::shared_ptr<const Artifact> InputCache::get(const TaskInput& input) {
  std::shared_ptr<Entry> entry;
  {
    const std::lock_guard lock(mutex_);
    std::shared_ptr<Entry>& known = entries_[input.content];
    if (!known) known = std::make_shared<Entry>();
    entry = known;
    if (entry->counted) uses_.splice(uses_.begin(), uses_, entry->use);
  }
  const std::lock_guard reading(entry->reading);
  if (entry->artifact) return entry->artifact;
  try {
    entry->artifact = store_.read(input.stage, input.key, input.content);
  } catch (...) {
    const std::lock_guard lock(mutex_);
    const auto it = entries_.find(input.content);
    if (it != entries_.end() && it->second == entry) entries_.erase(it);
    throw;
  }
  entry->bytes = size_of(*entry->artifact);
  count(input.content, *entry);
  return entry->artifact;
}

/// Enters a freshly read artifact and lets the least recently used ones go.
void InputCache::count(const Digest& content, Entry& entry) {
  const std::lock_guard lock(mutex_);
  const auto mine = entries_.find(content);
  if (mine == entries_.end() || mine->second.get() != &entry) return;  // cleared meanwhile
  uses_.push_front(content);
  entry.use = uses_.begin();
  entry.counted = true;
  bytes_ += entry.bytes;
  while (bytes_ > most_bytes_ && !uses_.empty()) {
    const auto oldest = entries_.find(uses_.back());
    bytes_ -= oldest->second->bytes;
    entries_.erase(oldest);
    uses_.pop_back();
  }
}

void InputCache::clear() {
  const std::lock_guard lock(mutex_);
  entries_.clear();
  uses_.clear();
  bytes_ = 0;
}

std::size_t InputCache::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

}  // namespace prt
