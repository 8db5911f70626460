// Colours the vertices of a mesh with a light that moves: the simplest way to put a package into an
// engine (Leonhardt & Bohn, §5).
//   vertex_colours PACKAGE.prt.glb OUT FRAMES      writes OUT0.ply, OUT1.ply, ...
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>

#include "base/error.h"
#include "package/read.h"
#include "player/evaluator.h"
#include "player/set_up.h"

namespace {

using Weights = std::vector<prt::SplatWeight>;

// Once for a mesh: the samples that each vertex takes its light from. None: no light gets there.
std::vector<Weights> weights_of_vertices(const prt::Evaluator& evaluator, const prt::Scene& mesh) {
  std::vector<Weights> weights(mesh.positions.size());
  for (std::size_t v = 0; v < weights.size(); ++v) {
    evaluator.splats().weights_at(mesh.positions[v], mesh.normals[v], weights[v]);
  }
  return weights;
}

// Each frame: irradiance (W/m²) at a vertex, clamped here and not before.
prt::Vec3f irradiance_at(const Weights& weights, const prt::SampleIrradiance& played) {
  prt::Vec3f sum = prt::Vec3f::Zero();
  for (const auto& [sample, weight] : weights) {
    sum += weight * (played.direct.row(sample) + played.indirect.row(sample)).transpose();
  }
  return sum.cwiseMax(0.0F);
}

void write_ply(const std::string& file, const prt::Scene& mesh, const std::vector<Weights>& weights,
               const prt::SampleIrradiance& played) {
  std::ofstream out(file);
  out << "ply\nformat ascii 1.0\nelement vertex " << mesh.positions.size()
      << "\nproperty float x\nproperty float y\nproperty float z\n"
      << "property uchar red\nproperty uchar green\nproperty uchar blue\n"
      << "element face " << mesh.triangles.size() << "\nproperty list uchar int vertex_indices\n"
      << "end_header\n";
  for (std::size_t v = 0; v < weights.size(); ++v) {
    const prt::Vec3f irradiance = irradiance_at(weights[v], played);
    const Eigen::Array3f shown = irradiance.array() / (1.0F + irradiance.array());
    out << mesh.positions[v].transpose() << ' '
        << (255.0F * shown.sqrt()).round().cast<int>().transpose() << '\n';
  }
  for (const prt::Triangle& t : mesh.triangles) {
    out << "3 " << t.vertex[0] << ' ' << t.vertex[1] << ' ' << t.vertex[2] << '\n';
  }
  if (!out.flush()) throw prt::UserError(file + ": cannot be written");
}

void play(const std::string& file, const std::string& prefix, int frames) {
  const prt::Package package = prt::read_package(file);
  const prt::Evaluator evaluator(package);
  const std::vector<Weights> weights = weights_of_vertices(evaluator, package.scene);
  prt::Light light = prt::default_light(evaluator);
  prt::SampleIrradiance played;  // kept: after the first frame nothing is allocated
  for (int frame = 0; frame < frames; ++frame) {
    evaluator.evaluate({&light, 1}, {}, played);
    write_ply(prefix + std::to_string(frame) + ".ply", package.scene, weights, played);
    light.position.x() += 0.02F * package.scene.diagonal();
  }
}

}  // namespace

int main(int argc, char** argv) try {
  const int frames = argc == 4 ? std::atoi(argv[3]) : 0;
  if (frames < 1) throw prt::UserError("usage: vertex_colours PACKAGE.prt.glb OUT FRAMES");
  play(argv[1], argv[2], frames);
  return 0;
} catch (const prt::UserError& e) {
  std::fprintf(stderr, "vertex_colours: %s\n", e.what());
  return 2;
} catch (const std::exception& e) {
  std::fprintf(stderr, "vertex_colours: %s\n", e.what());
  return 1;
}
