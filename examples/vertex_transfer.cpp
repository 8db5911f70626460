// The transfer of each vertex: what an engine with a shader of its own wants of a package's
// environment layer.
//
//   vertex_transfer PACKAGE.prt.glb OUT.csv
//
// A line is a vertex of the scene's triangles: x,y,z,nx,ny,nz, then order² numbers for red, for
// green and for blue. Their dot product with the environment's coefficients in the same colour
// (player/environment_light.h) is the vertex's irradiance, W/m²; times albedo / π it is radiance.
#include <cstdio>
#include <exception>
#include <fstream>
#include <vector>

#include "package/read.h"
#include "player/evaluator.h"

namespace {

/// Irradiance at all points by each function of the environment alone: points × 3, per function.
std::vector<std::vector<prt::Vec3f>> transfer_at(const prt::Evaluator& evaluator,
                                                 const std::vector<prt::PlayPoint>& points) {
  const int order = prt::environment_order(evaluator.package());
  std::vector<std::vector<prt::Vec3f>> transfer;
  for (int k = 0; k < order * order; ++k) {
    prt::MatrixF one = prt::MatrixF::Zero(3, order * order);
    one.col(k).setOnes();
    std::vector<prt::Vec3f> of_function;
    for (const auto& at : evaluator.reconstruct(evaluator.evaluate({}, one), points)) {
      of_function.emplace_back(at.direct + at.indirect);
    }
    transfer.push_back(std::move(of_function));
  }
  return transfer;
}

void write(const std::string& package_file, const std::string& csv) {
  const prt::Package package = prt::read_package(package_file);
  prt::require_environment(package, package_file);
  const prt::Evaluator evaluator(package);
  std::vector<prt::PlayPoint> points;
  for (std::size_t v = 0; v < package.scene.positions.size(); ++v) {
    const prt::Vec3f normal = package.scene.normals[v];
    points.push_back({package.scene.positions[v], normal, normal});
  }
  const auto transfer = transfer_at(evaluator, points);
  std::ofstream out(csv);
  for (std::size_t v = 0; v < points.size(); ++v) {
    const prt::Vec3f &p = points[v].position, &n = points[v].normal;
    out << p.x() << ',' << p.y() << ',' << p.z() << ',' << n.x() << ',' << n.y() << ',' << n.z();
    for (int channel = 0; channel < 3; ++channel) {
      for (const auto& of_function : transfer) out << ',' << of_function[v][channel];
    }
    out << '\n';
  }
  if (!out.flush()) throw std::runtime_error(csv + ": cannot be written");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: vertex_transfer PACKAGE.prt.glb OUT.csv\n", stderr);
    return 2;
  }
  try {
    write(argv[1], argv[2]);
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "vertex_transfer: %s\n", e.what());
    return 2;
  }
}
