#include "apps/bake/bake_runner.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>

#include "apps/bake/history.h"
#include "apps/bake/memory.h"
#include "base/log.h"

namespace prt {

namespace {

constexpr std::size_t kCacheBytes = std::size_t{1} << 30;
/// A rank has to stay below 4 GiB; what running tasks hold comes on top of this.
constexpr std::size_t kTrimAboveBytes = std::size_t{5} << 29;

std::size_t resident_bytes() {
  std::ifstream in("/proc/self/statm");
  std::size_t total = 0;
  std::size_t resident = 0;
  in >> total >> resident;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace

class BakeRunner::Reader : public TaskReader {
 public:
  Reader(BakeRunner& runner, const Assignment& assignment, const std::atomic<bool>& stop)
      : runner_(runner), assignment_(assignment), stop_(stop) {}

  [[nodiscard]] const Scene& scene() const override { return runner_.world_.scene; }
  [[nodiscard]] const RayCaster& ray_caster() const override { return runner_.ray_caster(); }
  [[nodiscard]] std::shared_ptr<const Artifact> input(std::size_t i) const override {
    const TaskInput& input = assignment_.inputs.at(i);
    try {
      return runner_.cache_.get(input);
    } catch (const UnsoundData& e) {
      throw InputDistrusted(input.id, e.what());
    }
  }
  [[nodiscard]] Digest input_content(std::size_t i) const override {
    return assignment_.inputs.at(i).content;
  }
  [[nodiscard]] Memo& memo() const override { return runner_.memo_; }
  [[nodiscard]] bool stop_requested() const override { return stop_; }

 private:
  BakeRunner& runner_;
  const Assignment& assignment_;
  const std::atomic<bool>& stop_;
};

BakeRunner::BakeRunner(const BakeWorld& world) : world_(world), cache_(world.store, kCacheBytes) {}

TaskRunner::Made BakeRunner::run(const Assignment& assignment, const std::atomic<bool>& stop) {
  const TaskSpec& task = assignment.task;
  const log::Subject subject(task.id);
  const auto began = std::chrono::steady_clock::now();
  Made made;
  if (const auto content = adopt(assignment)) {
    made.content = *content;
    made.adopted = true;
  } else {
    const Artifact artifact = make(task, Reader(*this, assignment, stop));
    made.content = world_.store.write(task.kind, assignment.key, artifact,
                                      {task.version, world_.method.equation(task.kind)});
    made.figures = figures_of(artifact);
  }
  made.bytes = world_.store.bytes(task.kind, assignment.key);
  stay_small();
  log::debug("{} in {:.3f} s, {} bytes", made.adopted ? "found" : "made",
             std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count(),
             made.bytes);
  return made;
}

std::optional<Digest> BakeRunner::adopt(const Assignment& assignment) {
  const std::string& stage = assignment.task.kind;
  const auto content = world_.store.check(stage, assignment.key);
  if (!content || !assignment.expected || *assignment.expected == *content) return content;
  // Sound by itself, but not what was made under this KEY before: a foreign file.
  log::warn("{}: is not the artifact that the manifest knows; it will be made again",
            world_.store.path(stage, assignment.key).string());
  world_.store.remove(stage, assignment.key);
  return std::nullopt;
}

Artifact BakeRunner::make(const TaskSpec& task, const TaskReader& reader) const {
  const BakeErrorMeter* evaluator = world_.program.evaluator.get();
  if (evaluator != nullptr && std::ranges::count(evaluator->kinds(), task.kind) > 0) {
    return evaluator->run(task, reader, world_.method, world_.options);
  }
  return world_.method.run(task, reader);
}

const RayCaster& BakeRunner::ray_caster() {
  std::call_once(caster_made_,
                 [this] { caster_ = world_.program.make_ray_caster(world_.scene, world_.isa); });
  return *caster_;
}

void BakeRunner::stay_small() {
  if (resident_bytes() < kTrimAboveBytes) return;
  cache_.clear();
  memo_.trim();
  return_freed_memory();
}

}  // namespace prt
