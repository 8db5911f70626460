// Checks or makes one artifact: what every task of a bake does on every rank.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>

#include "apps/bake/bake.h"
#include "apps/bake/input_cache.h"
#include "jobs/slots.h"
#include "store/artifact_store.h"

namespace prt {

/// What a rank bakes with.
struct BakeWorld {
  const BakeProgram& program;
  const Method& method;
  const OptionValues& options;
  const Scene& scene;
  std::string isa;  ///< instruction set that all ranks share
  ArtifactStore& store;
};

/// Verifies an artifact that lies on disk under the task's KEY; where there is none, or no sound
/// one, runs the task and stores its result. So resuming, adopting and verifying are one path.
class BakeRunner : public TaskRunner {
 public:
  explicit BakeRunner(const BakeWorld& world);
  Made run(const Assignment& assignment, const std::atomic<bool>& stop) override;

 private:
  class Reader;
  std::optional<Digest> adopt(const Assignment& assignment);
  Artifact make(const TaskSpec& task, const TaskReader& reader) const;
  const RayCaster& ray_caster();
  void stay_small();

  BakeWorld world_;
  InputCache cache_;
  Memo memo_;
  std::once_flag caster_made_;
  std::unique_ptr<RayCaster> caster_;
};

}  // namespace prt
