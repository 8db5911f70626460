// The part of a scene that one task works on: in a big scene the window of its region.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "domains/windows.h"
#include "methods/common/inputs.h"

namespace prt::lb {

/// Task id of the artifact that says which clusters go together. A task that works in a window has
/// it as its last input and its region's number as the parameter "region"; without that parameter
/// the whole scene is its part.
inline constexpr const char* kWindowsTask = "windows";

/// Some clusters of a scene. Within it clusters and samples are numbered by themselves, in the
/// scene's order: what works on a whole scene works on a part of one.
class ScenePart {
 public:
  /// All of `scene`.
  explicit ScenePart(std::shared_ptr<const SharedSamples> scene);
  /// `clusters`: ascending.
  ScenePart(std::shared_ptr<const SharedSamples> scene, std::vector<std::uint32_t> clusters);

  [[nodiscard]] const SampleSet& samples() const { return own_->samples; }
  [[nodiscard]] const std::vector<std::uint32_t>& cluster_of_sample() const {
    return own_->cluster_of_sample;
  }
  /// The scene's numbers of this part's clusters.
  [[nodiscard]] const std::vector<std::uint32_t>& clusters() const { return clusters_; }
  /// This part's number of a cluster of the scene; kNone if it is outside.
  [[nodiscard]] std::uint32_t local(std::uint32_t cluster) const { return local_[cluster]; }
  [[nodiscard]] bool is_whole() const { return own_ == scene_; }
  /// This part's number of one of the scene's samples; kNone if it is outside.
  [[nodiscard]] std::uint32_t local_sample(std::uint32_t sample) const;
  /// Rows of this part's samples, of one row per sample of the scene.
  [[nodiscard]] MatrixF rows(MatrixF of_scene) const;
  /// Ray hits (transport/hemisphere.h) in this part's numbers; hits outside count as lost.
  [[nodiscard]] std::vector<std::uint32_t> local_senders(
      std::span<const std::uint32_t> senders) const;

 private:
  std::shared_ptr<const SharedSamples> scene_;
  std::shared_ptr<const SharedSamples> own_;
  std::vector<std::uint32_t> clusters_;
  std::vector<std::uint32_t> local_;  // of every cluster of the scene
};

/// Inputs of the task but for the windows.
std::size_t own_inputs(const TaskSpec& task);
/// Regions of the task's last input; empty where the task has none.
std::shared_ptr<const std::vector<Region>> shared_regions(const TaskSpec& task,
                                                          const TaskReader& reader);
/// The window of the task's region, or the whole scene. Samples are input 0.
std::shared_ptr<const ScenePart> shared_window(const TaskSpec& task, const TaskReader& reader);
/// The region's own clusters, or the whole scene.
std::shared_ptr<const ScenePart> shared_region(const TaskSpec& task, const TaskReader& reader);

/// Regions of an artifact of the kind "windows". Throws UnsoundData where they do not fit together.
std::vector<Region> get_regions(const Artifact& artifact);
/// Such an artifact. `gain`: largest of uniform_irradiance (domains/windows.h).
Artifact put_regions(const std::vector<Region>& regions, double gain);

/// samples, rays/c → which clusters fill how much of a cluster's hemispheres.
Artifact run_reach(const TaskSpec& task, const TaskReader& reader);
/// samples, albedo, reach/* → regions and their windows.
Artifact run_windows(const TaskSpec& task, const TaskReader& reader);

}  // namespace prt::lb
