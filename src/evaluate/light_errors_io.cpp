#include "evaluate/light_errors_io.h"

#include <array>

#include "base/error.h"

namespace prt {
namespace {

/// A struct's fields in the order they are stored.
template <typename Sums>
struct Fields;

template <>
struct Fields<IrradianceSums> {
  static constexpr std::array kMembers = {
      &IrradianceSums::squared_error, &IrradianceSums::squared_power, &IrradianceSums::noise_mm,
      &IrradianceSums::noise_mr,      &IrradianceSums::noise_rr,      &IrradianceSums::negative};
};

template <>
struct Fields<VisibilitySums> {
  static constexpr std::array kMembers = {&VisibilitySums::wrong, &VisibilitySums::soft,
                                          &VisibilitySums::weight, &VisibilitySums::irradiance_soft,
                                          &VisibilitySums::irradiance};
};

/// Numbers per struct: its fields and the count of what was not finite.
template <typename Sums>
constexpr std::size_t kWidth = Fields<Sums>::kMembers.size() + 1;

constexpr std::array kParts = {&LightErrors::direct, &LightErrors::indirect,
                               &LightErrors::direct_surface, &LightErrors::indirect_surface,
                               &LightErrors::indirect_of_exact};

template <typename Sums>
void append(std::vector<double>& values, const Sums& sums) {
  for (const auto member : Fields<Sums>::kMembers) values.push_back(sums.*member);
  values.push_back(static_cast<double>(sums.not_finite));
}

template <typename Sums>
Sums take(std::span<const double> values, std::size_t i) {
  Sums sums;
  const auto own = values.subspan(i * kWidth<Sums>, kWidth<Sums>);
  for (std::size_t k = 0; k + 1 < own.size(); ++k) sums.*Fields<Sums>::kMembers[k] = own[k];
  if (!(own.back() >= 0.0 && own.back() < 0x1p53)) {
    throw UnsoundData("a count of points in the sums of test lights is none");
  }
  sums.not_finite = static_cast<std::uint64_t>(own.back());
  return sums;
}

void put_clusters(Artifact& out, const std::string& name, std::span<const LightErrors> lights,
                  std::vector<IrradianceSums> LightErrors::*part) {
  std::vector<double> values;
  for (const LightErrors& light : lights) {
    for (const IrradianceSums& sums : light.*part) append(values, sums);
  }
  out.put<double>(name, values, {lights.size(), (lights[0].*part).size(), kWidth<IrradianceSums>},
                  "(W/m^2)^2", "sums of squares by test light and cluster (evaluate/metrics.h)");
}

/// `name`, whose length must be `count`.
std::span<const double> sized(const Artifact& in, const std::string& name, std::size_t count) {
  const auto values = in.values<double>(name);
  if (values.size() != count) throw UnsoundData("array " + name + " does not fit the lights");
  return values;
}

}  // namespace

void put_light_errors(Artifact& out, std::span<const LightErrors> lights) {
  std::vector<Vec3f> positions;
  std::vector<double> sums, visibility, unreached;
  for (const LightErrors& light : lights) {
    positions.push_back(light.position);
    for (const auto part : kParts) append(sums, light.*part);
    append(visibility, light.visibility);
    unreached.push_back(light.unreached);
  }
  out.put("light_position", positions, "m", "test lights");
  out.put<double>("sums", sums, {lights.size(), kParts.size(), kWidth<IrradianceSums>}, "(W/m^2)^2",
                  "sums of squares by test light: direct and indirect at samples, the same on the "
                  "surface, indirect at samples from exact direct light (evaluate/metrics.h)");
  put_clusters(out, "direct_by_cluster", lights, &LightErrors::direct_by_cluster);
  put_clusters(out, "indirect_by_cluster", lights, &LightErrors::indirect_by_cluster);
  out.put<double>("visibility", visibility, {lights.size(), kWidth<VisibilitySums>}, "1",
                  "sums of shadow tests by test light (evaluate/metrics.h)");
  out.put<double>("unreached", unreached, {lights.size()}, "1",
                  "share of the surface that no splat reaches");
}

std::vector<LightErrors> get_light_errors(const Artifact& in) {
  const auto positions = in.points("light_position");
  const std::size_t count = positions.size();
  constexpr std::size_t kSums = kWidth<IrradianceSums>;
  const auto sums = sized(in, "sums", count * kParts.size() * kSums);
  const auto visibility = sized(in, "visibility", count * kWidth<VisibilitySums>);
  const auto unreached = sized(in, "unreached", count);
  const std::size_t all = in.values<double>("direct_by_cluster").size();
  const std::size_t clusters = count == 0 ? 0 : all / (count * kSums);
  const auto direct = sized(in, "direct_by_cluster", count * clusters * kSums);
  const auto indirect = sized(in, "indirect_by_cluster", count * clusters * kSums);
  std::vector<LightErrors> lights(count);
  for (std::size_t k = 0; k < count; ++k) {
    LightErrors& light = lights[k];
    light.position = positions[k];
    for (std::size_t p = 0; p < kParts.size(); ++p) {
      light.*kParts[p] = take<IrradianceSums>(sums, k * kParts.size() + p);
    }
    light.visibility = take<VisibilitySums>(visibility, k);
    light.unreached = unreached[k];
    for (std::size_t c = 0; c < clusters; ++c) {
      light.direct_by_cluster.push_back(take<IrradianceSums>(direct, k * clusters + c));
      light.indirect_by_cluster.push_back(take<IrradianceSums>(indirect, k * clusters + c));
    }
  }
  return lights;
}

}  // namespace prt
