#include "player/gl/light_pass.h"

#include "player/evaluator.h"
#include "player/gl/quad_rows.h"

namespace prt::gl {
namespace {

bool casts_shadows(const Package& package) {
  for (const ProgramStep& step : package.program) {
    const auto* direct = std::get_if<DirectLightStep>(&step);
    if (direct != nullptr && direct->shadow == DirectLightStep::Shadow::kDepth) return true;
  }
  return false;
}

int bits_of(const DepthVisibility& visibility, QuantisedMatrix DepthBlock::*part) {
  std::vector<const QuantisedMatrix*> matrices;
  for (const DepthBlock& block : visibility.clusters) matrices.push_back(&(block.*part));
  return QuadRows::bits_of(matrices);
}

/// The depth buffers of all clusters in the order that shaders/visibility.glsl reads them.
struct DepthRows {
  explicit DepthRows(const DepthVisibility& visibility)
      : coefficients(bits_of(visibility, &DepthBlock::coefficients)),
        basis(bits_of(visibility, &DepthBlock::basis)) {}

  void add(const DepthBlock& block, std::uint32_t first_sample, std::uint32_t samples) {
    const std::uint32_t functions = block.basis.rows;
    const bool seen = block.mean.rows == 0;
    clusters.insert(clusters.end(),
                    {static_cast<std::int32_t>(first_sample), int(coefficients.quads()),
                     int(basis.quads()), int(quads_for(functions)), int(basis_scales.size() / 4),
                     seen ? -1 : int(means.size()), int(walls.size()), int(block.walls.rows())});
    for (std::uint32_t i = 0; i < samples; ++i) {
      for (std::uint32_t k = 0; k < functions; ++k) coefficients.append(block.coefficients, i, k);
      coefficients.pad();
      coefficient_scales.push_back(functions == 0 ? 0.0F : block.coefficients.scales[i]);
    }
    for (std::uint32_t d = 0; d < block.basis.cols && functions > 0; ++d) {
      for (std::uint32_t k = 0; k < functions; ++k) basis.append(block.basis, k, d);
      basis.pad();
    }
    for (std::uint32_t k = 0; k < functions; ++k) basis_scales.push_back(block.basis.scales[k]);
    while (basis_scales.size() % 4 != 0) basis_scales.push_back(0.0F);
    if (!seen) {
      const MatrixF mean = block.mean.decode();
      means.insert(means.end(), mean.data(), mean.data() + mean.size());
    }
    for (Eigen::Index w = 0; w < block.walls.rows(); ++w) {
      walls.emplace_back(block.walls.row(w).transpose());
    }
  }

  QuadRows coefficients;  // samples × functions
  QuadRows basis;         // directions × functions
  std::vector<std::int32_t> clusters;
  std::vector<float> coefficient_scales, basis_scales, means;
  std::vector<Eigen::Vector4f> walls;
};

}  // namespace

LightPass::LightPass(const Package& package, const SampleBuffers& samples)
    : samples_(&samples), shadows_(casts_shadows(package)) {
  if (shadows_) upload(*package.visibility, package.samples);
}

void LightPass::upload(const DepthVisibility& visibility, const SampleSet& samples) {
  const HemisphereDirections directions(visibility.directions);
  grid_width_ = directions.width();
  grid_height_ = directions.height();
  bound_ = visibility.bound;
  bias_ = visibility.bias;
  DepthRows rows(visibility);
  for (std::size_t c = 0; c < visibility.clusters.size(); ++c) {
    rows.add(visibility.clusters[c], samples.cluster_begin[c], samples.cluster_size(c));
  }
  if (rows.coefficients.floats()) defines_ += "#define FLOAT_COEFFICIENTS\n";
  if (rows.basis.floats()) defines_ += "#define FLOAT_BASIS\n";
  clusters_ = texels(GL_RGBA32UI, 16, rows.clusters);
  coefficients_ = rows.coefficients.upload();
  coefficient_scales_ = texels(GL_R32F, 4, rows.coefficient_scales);
  basis_ = rows.basis.upload();
  basis_scales_ = texels(GL_RGBA32F, 16, rows.basis_scales);
  means_ = texels(GL_R32F, 4, rows.means);
  walls_ = vec4_texels(rows.walls);
}

Program& LightPass::program(const std::string& light_defines) {
  const auto known = programs_.find(light_defines);
  if (known != programs_.end()) return known->second;
  Program made = Program::compute({"lights.glsl", "visibility.glsl"}, defines_ + light_defines);
  made.use();
  glUniform2i(0, grid_width_, grid_height_);
  made.set("bound", bound_);
  made.set("bias", bias_);
  made.set("wall_slack", kWallSlack * bound_);
  made.set("unlit", kUnlit);
  made.set("shadows", shadows_ ? 1 : 0);
  return programs_.emplace(light_defines, std::move(made)).first->second;
}

void LightPass::bind() const {
  samples_->positions.read_at(2);
  samples_->normals.read_at(3);
  samples_->tangents.read_at(4);
  samples_->groups.read_at(5);
  if (!shadows_) return;
  clusters_.read_at(6);
  coefficients_.read_at(7);
  coefficient_scales_.read_at(8);
  basis_.read_at(9);
  basis_scales_.read_at(10);
  means_.read_at(11);
  walls_.read_at(12);
}

void LightPass::run(const LightTable& lights, const TexelBuffer& irradiance,
                    const SampleFields& fields) {
  if (lights.count() == 0) return irradiance.clear();
  Program& work = program(lights.defines());
  work.use();
  lights.bind();
  bind();
  irradiance.write_at(0);
  fields.buffer.write_at(1);
  work.set("field_stride", fields.stride);
  for (int light = 0; light < lights.count(); ++light) {
    work.set("light_index", light);
    work.set("field", 3 + light);
    work.set("first_light", light == 0 ? 1 : 0);
    dispatch(samples_->group_count * kGroup, kGroup);
  }
}

}  // namespace prt::gl
