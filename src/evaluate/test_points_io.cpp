#include "evaluate/test_points_io.h"

#include "base/error.h"

namespace prt {
namespace {

/// (r1, r2) of all points: n × 2 × 3.
void put_pairs(Artifact& out, const std::string& name,
               const std::vector<IrradianceEstimate>& estimates,
               std::array<Vec3f, 2> IrradianceEstimate::*part, const std::string& meaning) {
  std::vector<float> values;
  for (const IrradianceEstimate& e : estimates) {
    for (const Vec3f& half : e.*part) values.insert(values.end(), half.data(), half.data() + 3);
  }
  out.put<float>(name, values, {estimates.size(), 2, 3}, "W/m^2", meaning);
}

void get_pairs(const Artifact& in, const std::string& name,
               std::vector<IrradianceEstimate>& estimates,
               std::array<Vec3f, 2> IrradianceEstimate::*part) {
  const auto values = in.values<float>(name);
  if (values.size() != 6 * estimates.size()) {
    throw UnsoundData("array " + name + " does not fit the points");
  }
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    for (std::size_t half = 0; half < 2; ++half) {
      (estimates[i].*part)[half] = Eigen::Map<const Vec3f>(&values[6 * i + 3 * half]);
    }
  }
}

void put_set(Artifact& out, const std::string& name, const TestSet& set) {
  std::vector<Vec3f> positions, normals;
  for (const ReceiverPoint& p : set.points) {
    positions.push_back(p.position);
    normals.push_back(p.normal);
  }
  out.put(name + "_position", positions, "m", "test points");
  out.put(name + "_normal", normals, "1", "unit normals of the test points");
  out.put<float>(name + "_weight", set.weights, {set.weights.size()}, "1",
                 "share of the area that each test point stands for");
  put_pairs(out, name + "_direct", set.reference, &IrradianceEstimate::direct,
            "direct irradiance, two independent path-traced references");
  put_pairs(out, name + "_indirect", set.reference, &IrradianceEstimate::indirect,
            "indirect irradiance, two independent path-traced references");
}

TestSet get_set(const Artifact& in, const std::string& name) {
  TestSet set;
  const auto positions = in.points(name + "_position"), normals = in.points(name + "_normal");
  set.weights = in.vector<float>(name + "_weight");
  if (positions.size() != normals.size() || positions.size() != set.weights.size()) {
    throw UnsoundData("test points of a reference do not fit together");
  }
  for (std::size_t i = 0; i < positions.size(); ++i)
    set.points.push_back({positions[i], normals[i]});
  set.reference.resize(positions.size());
  get_pairs(in, name + "_direct", set.reference, &IrradianceEstimate::direct);
  get_pairs(in, name + "_indirect", set.reference, &IrradianceEstimate::indirect);
  return set;
}

}  // namespace

void put_test_points(Artifact& out, const TestPoints& points) {
  out.put<std::uint32_t>("sample_index", points.sample_index, {points.sample_index.size()}, "1",
                         "samples that are test points");
  put_set(out, "sample", points.at_samples);
  put_set(out, "surface", points.on_surface);
}

TestPoints get_test_points(const Artifact& in) {
  TestPoints points;
  points.sample_index = in.vector<std::uint32_t>("sample_index");
  points.at_samples = get_set(in, "sample");
  points.on_surface = get_set(in, "surface");
  if (points.sample_index.size() != points.at_samples.points.size()) {
    throw UnsoundData("sample points of a reference do not fit together");
  }
  return points;
}

}  // namespace prt
