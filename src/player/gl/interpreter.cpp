#include "player/gl/interpreter.h"

#include "player/environment_light.h"

namespace prt::gl {

namespace {

CoefficientLayout layout_of_environment(const Package& package) {
  const auto order = static_cast<std::uint32_t>(environment_order(package));
  return CoefficientLayout(environment_layout(order * order, package.samples.clusters()));
}

}  // namespace

Interpreter::Interpreter(const Package& package, const SampleBuffers& samples)
    : package_(package),
      samples_(samples),
      light_(package, samples),
      to_fields_(Program::compute({"indirect_fields.glsl"})),
      direct_(GL_RGBA32F, 16, sample_texels(samples.count)),
      environment_layout_(layout_of_environment(package)) {
  for (const ProgramStep& step : package.program) {
    if (const auto* light = std::get_if<DirectLightStep>(&step)) {
      values_[light->output] = {.samples = {.direct_share = 1.0F}};
    }
    if (const auto* light = std::get_if<EnvironmentLightStep>(&step)) plan(*light);
    if (const auto* application = std::get_if<ApplyStep>(&step)) plan(*application);
    if (const auto* addition = std::get_if<AddStep>(&step)) plan(*addition);
    if (const auto* reconstruct = std::get_if<ReconstructStep>(&step)) {
      indirect_ = values_.at(reconstruct->input).samples.rest;
      sky_ = values_.at(reconstruct->input).samples.sky;
    }
  }
}

TexelBuffer& Interpreter::space(const std::string& name, std::size_t texels) {
  return spaces_.insert_or_assign(name, TexelBuffer(GL_RGBA32F, 16, texels)).first->second;
}

const TexelBuffer* Interpreter::sum(const TexelBuffer* a, const TexelBuffer* b,
                                    const std::string& name) {
  if (a == nullptr || b == nullptr) return a == nullptr ? b : a;
  const TexelBuffer* total = &space(name, a->texels());
  steps_.emplace_back([this, a, b, total] { combine_.run(1.0F, *a, 1.0F, *b, *total); });
  return total;
}

SampleValue Interpreter::joined(const SampleValue& value, const std::string& name) {
  return {.direct_share = value.direct_share,
          .rest = sum(value.sky, value.rest, name + " with sky")};
}

const TexelBuffer& Interpreter::whole(const Value& value, const std::string& name) {
  const SampleValue parts = joined(value.samples, name);
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
  return {.samples = {}, .coefficients = &out, .layout = &pass->layout()};
}

Interpreter::Value Interpreter::apply(const ClusterTransfer& transfer, const ApplyStep& step) {
  const Value& value = values_.at(step.input);
  auto& pass = transfers_[{step.op, value.layout}];
  if (!pass) {
    pass = std::make_unique<TransferPass>(transfer, *value.layout, package_.samples, samples_);
  }
  const TexelBuffer& out = space(step.output, sample_texels(samples_.count));
  steps_.emplace_back([&pass = *pass, &in = *value.coefficients, &out] { pass.run(in, out); });
  return {.samples = {.rest = &out}};
}

Interpreter::Value Interpreter::apply(const NearTransfer& near, const ApplyStep& step) {
  auto& pass = nears_[step.op];
  if (!pass) pass = std::make_unique<NearPass>(near);
  const SampleValue in = joined(values_.at(step.input).samples, step.input);
  const TexelBuffer& out = space(step.output, sample_texels(samples_.count));
  steps_.emplace_back([this, &pass = *pass, in, &out] { pass.run(in, direct_, out); });
  return {.samples = {.rest = &out}};
}

void Interpreter::plan(const ApplyStep& step) {
  values_[step.output] =
      std::visit([&](const auto& op) { return apply(op, step); }, package_.operators.at(step.op));
}

/// What the environment brings directly is kept apart, so that pictures can show it with the
/// lights'.
void Interpreter::plan(const EnvironmentLightStep& step) {
  values_[step.coefficients] = {
      .samples = {}, .coefficients = &environment_, .layout = &environment_layout_};
  plan(ApplyStep{step.op, step.coefficients, step.output});
  SampleValue& direct = values_.at(step.output).samples;
  std::swap(direct.sky, direct.rest);
}

void Interpreter::plan(const AddStep& step) {
  const Value a = values_.at(step.a);
  const Value b = values_.at(step.b);
  Value total = a;
  if (a.coefficients != nullptr) {
    total.coefficients = sum(a.coefficients, b.coefficients, step.output);
  } else {
    total.samples.direct_share += b.samples.direct_share;
    total.samples.sky = sum(a.samples.sky, b.samples.sky, step.output + " sky");
    total.samples.rest = sum(a.samples.rest, b.samples.rest, step.output);
  }
  values_[step.output] = total;
}

void Interpreter::set_environment(const MatrixF& environment) {
  const std::size_t row = std::size_t{4} * environment_layout_.channel_quads();
  std::vector<float> values(3 * row, 0.0F);
  for (Eigen::Index channel = 0; channel < environment.rows(); ++channel) {
    for (Eigen::Index k = 0; k < environment.cols(); ++k) {
      values[static_cast<std::size_t>(channel) * row + static_cast<std::size_t>(k)] =
          environment(channel, k);
    }
  }
  environment_ = TexelBuffer(GL_RGBA32F, 16, std::as_bytes(std::span(values)));
}

void Interpreter::run(const LightTable& lights, const MatrixF& environment,
                      const SampleFields& fields, Show show) {
  check_environment(package_, environment);
  if (environment_layout_.channel_quads() > 0) set_environment(environment);
  light_.run(lights, direct_, fields);
  for (const auto& step : steps_) step();
  this->show(fields, show);
}

void Interpreter::show(const SampleFields& fields, Show show) {
  to_fields_.use();
  to_fields_.set("count", static_cast<int>(samples_.count));
  to_fields_.set("field_stride", fields.stride);
  const bool indirect = indirect_ != nullptr && show != Show::kDirect;
  const bool sky = sky_ != nullptr && show != Show::kIndirect;
  to_fields_.set("indirect_share", indirect ? 1.0F : 0.0F);
  to_fields_.set("sky_share", sky ? 1.0F : 0.0F);
  (indirect ? *indirect_ : direct_).read_at(0);
  (sky ? *sky_ : direct_).read_at(2);
  fields.buffer.write_at(1);
  dispatch(samples_.count, kGroup);
}

MatrixF Interpreter::download(const TexelBuffer* buffer) const {
  MatrixF irradiance = MatrixF::Zero(static_cast<Eigen::Index>(samples_.count), 3);
  if (buffer == nullptr) return irradiance;
  const std::vector<float> values = buffer->download(4 * samples_.count);
  for (Eigen::Index i = 0; i < irradiance.rows(); ++i) {
    for (Eigen::Index c = 0; c < 3; ++c) {
      irradiance(i, c) = values[static_cast<std::size_t>(4 * i + c)];
    }
  }
  return irradiance;
}

MatrixF Interpreter::direct() const { return download(&direct_); }
MatrixF Interpreter::sky() const { return download(sky_); }
MatrixF Interpreter::indirect() const { return download(indirect_); }

}  // namespace prt::gl
