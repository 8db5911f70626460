#include "package/package.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "base/error.h"
#include "bases/spherical_harmonics.h"

namespace prt {
namespace {

/// Samples lie on triangles: a share of the scene's diagonal covers rounding.
constexpr float kOffSceneTolerance = 1e-3F;
/// Unit vectors may be stored in 16-bit integers.
constexpr float kUnitTolerance = 1e-2F;

/// Ends validation with one line that says what is wrong and what to do.
class Judge {
 public:
  explicit Judge(const std::string& file) : file_(file) {}
  void require(bool sound, std::string_view what) const {
    if (!sound) {
      throw UserError(
          fmt::format("{}: not a sound package: {}; bake or copy it again", file_, what));
    }
  }
  [[nodiscard]] const std::string& file() const { return file_; }

 private:
  const std::string& file_;
};

bool finite(std::span<const float> values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

/// rows may be anything when there are no columns: such a matrix holds nothing.
void check_matrix(const QuantisedMatrix& m, const std::string& what, const Judge& judge) {
  const std::size_t size = std::size_t{m.rows} * m.cols;
  judge.require(m.bits == 8 || m.bits == 16 || m.bits == 32, what + " has unknown bits");
  judge.require(m.int8.size() == (m.bits == 8 ? size : 0) &&
                    m.int16.size() == (m.bits == 16 ? size : 0) &&
                    m.float32.size() == (m.bits == 32 ? size : 0),
                what + " has values that do not fit its shape");
  judge.require(size == 0 || m.scales.size() == m.rows, what + " needs a scale for each row");
  judge.require(finite(m.scales) && finite(m.float32), what + " has a value that is not finite");
}

bool is_shape(const QuantisedMatrix& m, std::uint64_t rows, std::uint64_t cols) {
  return m.rows == rows && m.cols == cols;
}

void check_clusters(const SampleSet& samples, const Judge& judge) {
  const auto& begin = samples.cluster_begin;
  judge.require(begin.size() >= 2 && begin.front() == 0 && begin.back() == samples.size() &&
                    std::is_sorted(begin.begin(), begin.end()),
                "the clusters do not divide the samples");
}

void check_samples(const Package& package, const Judge& judge) {
  const SampleSet& s = package.samples;
  const std::size_t n = s.size();
  judge.require(n > 0, "it has no samples");
  judge.require(s.normals.size() == n && s.tangents.size() == n && s.areas.size() == n &&
                    s.radii.size() == n && s.triangles.size() == n,
                "the arrays of the samples differ in length");
  check_clusters(s, judge);
  const float diagonal = package.scene.diagonal();
  const Vec3f slack = Vec3f::Constant(kOffSceneTolerance * diagonal);
  const Vec3f low = package.scene.bounds_min - slack;
  const Vec3f high = package.scene.bounds_max + slack;
  for (std::size_t i = 0; i < n; ++i) {
    const auto where = [&](const char* what) { return fmt::format("sample {} {}", i, what); };
    const Vec3f& p = s.positions[i];
    const bool inside = (p.array() >= low.array()).all() && (p.array() <= high.array()).all();
    if (!inside) judge.require(false, where("is not in the scene"));
    const bool unit = std::abs(s.normals[i].norm() - 1.0F) < kUnitTolerance &&
                      std::abs(s.tangents[i].norm() - 1.0F) < kUnitTolerance &&
                      std::abs(s.normals[i].dot(s.tangents[i])) < kUnitTolerance;
    if (!unit) judge.require(false, where("has no orthonormal frame"));
    if (!(s.areas[i] >= 0.0F && s.areas[i] <= diagonal * diagonal)) {
      judge.require(false, where("has an impossible area"));
    }
    if (!(s.radii[i] > 0.0F && s.radii[i] <= diagonal)) {
      judge.require(false, where("has an impossible radius"));
    }
    if (s.triangles[i] >= package.scene.triangles.size()) {
      judge.require(false, where("names a triangle that is not there"));
    }
  }
}

/// Planes beyond the scene would shut nothing out, and one that is not a plane anything.
void check_walls(const DepthBlock& block, const Scene& scene, const std::string& name,
                 const Judge& judge) {
  const MatrixF& walls = block.walls;
  if (walls.size() == 0) return;
  judge.require(block.mean.rows == 0, name + " has walls and depths");
  judge.require(walls.cols() == 4 && walls.rows() <= kMostWalls,
                name + " has walls of other shape");
  const Vec3f slack = Vec3f::Constant(kOffSceneTolerance * scene.diagonal());
  const Eigen::AlignedBox3f box(scene.bounds_min - slack, scene.bounds_max + slack);
  for (Eigen::Index w = 0; w < walls.rows(); ++w) {
    const Vec3f normal = walls.block<1, 3>(w, 0).transpose();
    judge.require(std::abs(normal.norm() - 1.0F) < kUnitTolerance,
                  name + " has a wall without a unit normal");
    const float centre = normal.dot(box.center());
    const float reach = 0.5F * normal.cwiseAbs().dot(box.sizes());
    judge.require(std::abs(walls(w, 3) - centre) <= reach, name + " has a wall off the scene");
  }
}

void check_visibility(const DepthVisibility& v, const Scene& scene, const SampleSet& samples,
                      const Judge& judge) {
  judge.require(std::isfinite(v.bound) && v.bound > 0.0F, "the depth bound is not positive");
  judge.require(v.bias >= 0.0F && v.bias < 1.0F, "the depth bias is not in [0, 1)");
  judge.require(v.clusters.size() == samples.clusters(),
                "depth buffers and samples differ in their clusters");
  judge.require(v.directions > 0 && v.directions <= kMaxDirections &&
                    HemisphereDirections::nearest_count(v.directions) == v.directions,
                fmt::format("{} directions are not possible", v.directions));
  const auto d = static_cast<std::uint64_t>(v.directions);
  for (std::size_t c = 0; c < v.clusters.size(); ++c) {
    const DepthBlock& block = v.clusters[c];
    const std::string name = fmt::format("the depth block of cluster {}", c);
    check_matrix(block.mean, name, judge);
    check_matrix(block.basis, name, judge);
    check_matrix(block.coefficients, name, judge);
    check_walls(block, scene, name, judge);
    const bool always_visible = block.mean.rows == 0;
    const std::uint32_t rank = block.basis.rows;
    judge.require(always_visible || is_shape(block.mean, 1, d),
                  name + " has a mean of other shape");
    judge.require(always_visible ? rank == 0 : (rank == 0 || block.basis.cols == d),
                  name + " has a basis of other shape");
    judge.require(rank == 0 ? block.coefficients.cols == 0
                            : is_shape(block.coefficients, samples.cluster_size(c), rank),
                  name + " has coefficients of other shape");
  }
}

/// First coefficient of each cluster; empty for a space of samples.
using Layout = std::vector<std::uint32_t>;

void check_operator(const ClusterProjection& projection, const SampleSet& samples,
                    const std::string& name, const Judge& judge) {
  judge.require(projection.blocks.size() == samples.clusters(),
                "operator " + name + " needs one block per cluster");
  for (std::size_t c = 0; c < projection.blocks.size(); ++c) {
    const QuantisedMatrix& block = projection.blocks[c];
    const std::string what = fmt::format("operator {}, cluster {}", name, c);
    check_matrix(block, what, judge);
    judge.require(block.rows == 0 || block.cols == samples.cluster_size(c),
                  what + " has a column too many or too few");
    judge.require(block.cols > 0 || block.rows == 0, what + " projects nothing");
  }
}

void check_operator(const ClusterTransfer& transfer, const SampleSet& samples,
                    const std::string& name, const Judge& judge) {
  judge.require(transfer.channels == 1 || transfer.channels == 3,
                "operator " + name + " must have 1 or 3 channels");
  judge.require(transfer.receivers.size() == samples.clusters(),
                "operator " + name + " needs one receiver per cluster");
  for (std::size_t r = 0; r < transfer.receivers.size(); ++r) {
    const ReceiverTransfer& t = transfer.receivers[r];
    const std::string what = fmt::format("operator {}, receiver {}", name, r);
    check_matrix(t.left, what, judge);
    check_matrix(t.right, what, judge);
    const bool ascending = std::adjacent_find(t.senders.begin(), t.senders.end(),
                                              std::greater_equal<>()) == t.senders.end();
    judge.require(ascending && (t.senders.empty() || t.senders.back() < samples.clusters()),
                  what + " has senders out of order or range");
    judge.require(
        t.left.cols == t.right.rows && (t.left.cols == 0 || t.left.rows == samples.cluster_size(r)),
        what + " has factors that do not fit together");
  }
}

void check_operator(const NearTransfer& near, const SampleSet& samples, const std::string& name,
                    const Judge& judge) {
  const std::string what = "operator " + name;
  const std::size_t n = samples.size();
  judge.require(near.channels == 1 || near.channels == 3, what + " must have 1 or 3 channels");
  judge.require(near.albedo.size() == n * near.channels, what + " needs an albedo per sample");
  judge.require(near.begin.size() == n + 1 && near.begin.front() == 0 &&
                    near.begin.back() == near.senders.size() &&
                    std::is_sorted(near.begin.begin(), near.begin.end()),
                what + " does not divide its entries among the samples");
  judge.require(near.shares.size() == near.senders.size(), what + " needs a share per sender");
  judge.require(
      std::all_of(near.senders.begin(), near.senders.end(), [&](std::uint32_t s) { return s < n; }),
      what + " names a sample that is not there");
}

/// Whether a transfer takes coefficients laid out like this.
bool fits(const ClusterTransfer& transfer, const Layout& layout) {
  for (const ReceiverTransfer& t : transfer.receivers) {
    std::uint64_t m = 0;
    for (const std::uint32_t s : t.senders) m += layout[s + 1] - layout[s];
    if (t.right.rows > 0 && t.right.cols != transfer.channels * m) return false;
  }
  return true;
}

/// Follows the program with types in place of values.
class ProgramCheck {
 public:
  ProgramCheck(const Package& package, const Judge& judge) : package_(package), judge_(judge) {}

  void run() {
    for (const Space& space : package_.spaces) {
      judge_.require(!space.name.empty() && spaces_.emplace(space.name, &space).second,
                     "the spaces need names of their own");
    }
    for (const ProgramStep& step : package_.program) {
      judge_.require(!finished_, "the program goes on after its reconstruct step");
      std::visit([this](const auto& s) { check(s); }, step);
    }
    judge_.require(finished_, "the program must end with a reconstruct step");
    judge_.require(direct_steps_ <= 1 && environment_steps_ <= 1,
                   "the program has several direct_light or environment_light steps");
    judge_.require(direct_steps_ + environment_steps_ > 0,
                   "the program needs a direct_light or an environment_light step");
  }

 private:
  void check(const DirectLightStep& step) {
    ++direct_steps_;
    judge_.require(step.shadow == DirectLightStep::Shadow::kNone || package_.visibility,
                   "the program wants depth shadows, but there are no depth buffers");
    write(step.output, Space::Kind::kSampleIrradiance, package_.samples.size(), {});
  }

  void check(const EnvironmentLightStep& step) {
    ++environment_steps_;
    const auto space = spaces_.find(step.coefficients);
    judge_.require(space != spaces_.end(),
                   "the program writes an unknown space " + step.coefficients);
    const std::uint32_t count = space->second->dimension;
    int order = 1;
    while (order < kMostShOrder && static_cast<std::uint32_t>(sh_count(order)) < count) ++order;
    judge_.require(static_cast<std::uint32_t>(sh_count(order)) == count,
                   fmt::format("an environment of {} coefficients has no order from 1 to {}", count,
                               kMostShOrder));
    write(step.coefficients, Space::Kind::kEnvironmentCoefficients, count,
          environment_layout(count, package_.samples.clusters()));
    check(ApplyStep{step.op, step.coefficients, step.output});
  }

  void check(const ApplyStep& step) {
    const auto op = package_.operators.find(step.op);
    judge_.require(op != package_.operators.end(),
                   "the program applies an unknown operator " + step.op);
    const Layout input = read(step.input);
    if (std::holds_alternative<NearTransfer>(op->second)) {
      judge_.require(input.empty(), "operator " + step.op + " takes irradiance at samples");
      write(step.output, Space::Kind::kSampleIrradiance, package_.samples.size(), {});
    } else if (const auto* projection = std::get_if<ClusterProjection>(&op->second)) {
      judge_.require(input.empty(), "operator " + step.op + " takes irradiance at samples");
      const Layout layout = projection->coefficient_begin();
      write(step.output, Space::Kind::kClusterCoefficients, layout.back(), layout);
    } else {
      judge_.require(!input.empty() && fits(std::get<ClusterTransfer>(op->second), input),
                     "operator " + step.op + " does not fit its input " + step.input);
      write(step.output, Space::Kind::kSampleIrradiance, package_.samples.size(), {});
    }
  }

  void check(const AddStep& step) {
    const Layout a = read(step.a);
    judge_.require(a == read(step.b), "the program adds " + step.a + " and " + step.b +
                                          ", which are of different kinds");
    const Space& space = *spaces_.at(step.a);
    write(step.output, space.kind, space.dimension, a);
  }

  void check(const ReconstructStep& step) {
    judge_.require(read(step.input).empty(), "only irradiance at samples can be reconstructed");
    finished_ = true;
  }

  Layout read(const std::string& name) const {
    const auto value = values_.find(name);
    judge_.require(value != values_.end(), "the program reads " + name + " before it is written");
    return value->second;
  }

  void write(const std::string& name, Space::Kind kind, std::uint64_t dimension, Layout layout) {
    const auto space = spaces_.find(name);
    judge_.require(space != spaces_.end(), "the program writes an unknown space " + name);
    judge_.require(space->second->kind == kind && space->second->dimension == dimension,
                   "space " + name + " has another kind or dimension than what is written to it");
    judge_.require(values_.emplace(name, std::move(layout)).second,
                   "the program writes " + name + " twice");
  }

  const Package& package_;
  const Judge& judge_;
  std::map<std::string, const Space*> spaces_;
  std::map<std::string, Layout> values_;
  int direct_steps_ = 0;
  int environment_steps_ = 0;
  bool finished_ = false;
};

}  // namespace

int environment_order(const Package& package) {
  for (const ProgramStep& step : package.program) {
    const auto* light = std::get_if<EnvironmentLightStep>(&step);
    if (light == nullptr) continue;
    const auto space = std::ranges::find(package.spaces, light->coefficients, &Space::name);
    if (space == package.spaces.end()) return 0;
    return static_cast<int>(std::lround(std::sqrt(space->dimension)));
  }
  return 0;
}

bool has_direct_light(const Package& package) {
  return std::ranges::any_of(package.program, [](const ProgramStep& step) {
    return std::holds_alternative<DirectLightStep>(step);
  });
}

void require_environment(const Package& package, const std::string& file_name) {
  if (environment_order(package) > 0) return;
  throw UserError(
      file_name +
      ": this package has no environment layer; bake it with methods: [lb, sh] (a scene that no "
      "light gets into has none even so), or "
      "leave --env out");
}

void require_direct_light(const Package& package, const std::string& file_name) {
  if (has_direct_light(package)) return;
  throw UserError(file_name +
                  ": this package takes environments alone, no lights; bake it with methods: [lb, "
                  "sh], or give --env");
}

std::vector<std::uint32_t> environment_layout(std::uint32_t coefficients, std::size_t clusters) {
  std::vector<std::uint32_t> begin(clusters + 1, coefficients);
  begin.front() = 0;
  return begin;
}

void validate(const Package& package, const std::string& file_name) {
  const Judge judge(file_name);
  check_samples(package, judge);
  if (package.visibility) {
    check_visibility(*package.visibility, package.scene, package.samples, judge);
  }
  for (const auto& [name, op] : package.operators) {
    std::visit([&, &n = name](const auto& o) { check_operator(o, package.samples, n, judge); }, op);
  }
  ProgramCheck(package, judge).run();
}

}  // namespace prt
