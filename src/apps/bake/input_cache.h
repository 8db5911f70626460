// Artifacts that tasks of this rank read, kept in memory while there is room.
#pragma once

#include <cstddef>
#include <list>
#include <map>
#include <memory>
#include <mutex>

#include "jobs/protocol.h"
#include "store/artifact_store.h"

namespace prt {

/// Thread-safe. Two threads that want the same artifact read it once.
class InputCache {
 public:
  InputCache(const ArtifactStore& store, std::size_t most_bytes);

  /// The verified artifact; throws UnsoundData if it cannot be trusted.
  std::shared_ptr<const Artifact> get(const TaskInput& input);
  /// Forgets everything; artifacts in use live on with their users.
  void clear();
  [[nodiscard]] std::size_t bytes() const;

 private:
  struct Entry {
    std::mutex reading;
    std::shared_ptr<const Artifact> artifact;  // guarded by reading until it is counted
    std::size_t bytes = 0;
    std::list<Digest>::iterator use;
    bool counted = false;
  };
  void count(const Digest& content, Entry& entry);

  const ArtifactStore& store_;
  std::size_t most_bytes_;
  mutable std::mutex mutex_;
  std::map<Digest, std::shared_ptr<Entry>> entries_;  // by content
  std::list<Digest> uses_;                            // counted ones, last used first
  std::size_t bytes_ = 0;
};

}  // namespace prt
