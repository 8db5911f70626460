#include "player/gl/interpreter.h"

namespace prt::gl {

Interpreter::Interpreter(const Package& package, const SampleBuffers& samples)
    : package_(package),
      samples_(samples),
      light_(package, samples),
      to_fields_(Program::compute({"indirect_fields.glsl"})),
      direct_(GL_RGBA32F, 16, sample_texels(samples.count)) {
  for (const ProgramStep& step : package.program) {
    if (const auto* light = std::get_if<DirectLightStep>(&step)) {
      values_[light->output] = {.samples = {.direct_share = 1.0F}};
    }
    if (const auto* application = std::get_if<ApplyStep>(&step)) plan(*application);
    if (const auto* addition = std::get_if<AddStep>(&step)) plan(*addition);
    if (const auto* reconstruct = std::get_if<ReconstructStep>(&step)) {
      indirect_ = values_.at(reconstruct->input).samples.rest;
    }
  }
}

TexelBuffer& Interpreter::space(const std::string& name, std::size_t texels) {
  return spaces_.insert_or_assign(name, TexelBuffer(GL_RGBA32F, 16, texels)).first->second;
}

const TexelBuffer& Interpreter::whole(const Value& value, const std::string& name) {
  const SampleValue& parts = value.samples;
  if (parts.rest != nullptr && parts.direct_share == 0.0F) return *parts.rest;
  if (parts.rest == nullptr && parts.direct_share == 1.0F) return direct_;
  const TexelBuffer& sum = space(name + " whole", sample_texels(samples_.count));
  steps_.emplace_back([this, parts, &sum] {
    const bool two = parts.rest != nullptr;
    combine_.run(parts.direct_share, direct_, two ? 1.0F : 0.0F, two ? *parts.rest : direct_, sum);
  });
  return sum;
}

Interpreter::Value Interpreter::apply(const ClusterProjection& projection, const ApplyStep& step) {
  auto& pass = projections_[step.op];
  if (!pass) pass = std::make_unique<ProjectionPass>(projection, package_.samples);
  const TexelBuffer& in = whole(values_.at(step.input), step.input);
  const TexelBuffer& out = space(step.output, std::size_t{3} * pass->layout().channel_quads());
  steps_.emplace_back([&pass = *pass, &in, &out] { pass.run(in, out); });
  return {.samples = {}, .coefficients = &out, .layout = pass.get()};
}

Interpreter::Value Interpreter::apply(const ClusterTransfer& transfer, const ApplyStep& step) {
  const Value& value = values_.at(step.input);
  auto& pass = transfers_[{step.op, value.layout}];
  if (!pass) {
    pass = std::make_unique<TransferPass>(transfer, value.layout->layout(), package_.samples,
                                          samples_);
  }
  const TexelBuffer& out = space(step.output, sample_texels(samples_.count));
  steps_.emplace_back([&pass = *pass, &in = *value.coefficients, &out] { pass.run(in, out); });
  return {.samples = {.rest = &out}};
}

Interpreter::Value Interpreter::apply(const NearTransfer& near, const ApplyStep& step) {
  auto& pass = nears_[step.op];
  if (!pass) pass = std::make_unique<NearPass>(near);
  const SampleValue in = values_.at(step.input).samples;
  const TexelBuffer& out = space(step.output, sample_texels(samples_.count));
  steps_.emplace_back([this, &pass = *pass, in, &out] { pass.run(in, direct_, out); });
  return {.samples = {.rest = &out}};
}

void Interpreter::plan(const ApplyStep& step) {
  values_[step.output] =
      std::visit([&](const auto& op) { return apply(op, step); }, package_.operators.at(step.op));
}

void Interpreter::plan(const AddStep& step) {
  const Value a = values_.at(step.a);
  const Value b = values_.at(step.b);
  const bool coefficients = a.coefficients != nullptr;
  const TexelBuffer* first = coefficients ? a.coefficients : a.samples.rest;
  const TexelBuffer* second = coefficients ? b.coefficients : b.samples.rest;
  Value sum = a;
  sum.samples.direct_share += b.samples.direct_share;
  const TexelBuffer* total = first != nullptr ? first : second;
  if (first != nullptr && second != nullptr) {
    total = &space(step.output, first->texels());
    steps_.emplace_back(
        [this, first, second, total] { combine_.run(1.0F, *first, 1.0F, *second, *total); });
  }
  (coefficients ? sum.coefficients : sum.samples.rest) = total;
  values_[step.output] = sum;
}

void Interpreter::run(const LightTable& lights, const SampleFields& fields) {
  light_.run(lights, direct_, fields);
  for (const auto& step : steps_) step();
  to_fields_.use();
  to_fields_.set("count", static_cast<int>(samples_.count));
  to_fields_.set("field_stride", fields.stride);
  to_fields_.set("share", indirect_ != nullptr ? 1.0F : 0.0F);
  (indirect_ != nullptr ? *indirect_ : direct_).read_at(0);
  fields.buffer.write_at(1);
  dispatch(samples_.count, kGroup);
}

MatrixF Interpreter::download(const TexelBuffer& buffer) const {
  const std::vector<float> values = buffer.download(4 * samples_.count);
  MatrixF irradiance(static_cast<Eigen::Index>(samples_.count), 3);
  for (Eigen::Index i = 0; i < irradiance.rows(); ++i) {
    for (Eigen::Index c = 0; c < 3; ++c) {
      irradiance(i, c) = values[static_cast<std::size_t>(4 * i + c)];
    }
  }
  return irradiance;
}

MatrixF Interpreter::direct() const { return download(direct_); }

MatrixF Interpreter::indirect() const {
  if (indirect_ == nullptr) return MatrixF::Zero(static_cast<Eigen::Index>(samples_.count), 3);
  return download(*indirect_);
}

}  // namespace prt::gl
