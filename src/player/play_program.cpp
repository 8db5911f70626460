#include "player/play_program.h"

#include <algorithm>

namespace prt {

PlayProgram::PlayProgram(const Package& package) : samples_(package.samples) {
  const int order = environment_order(package);
  environment_layout_ = std::make_unique<const std::vector<std::uint32_t>>(
      environment_layout(static_cast<std::uint32_t>(order * order), package.samples.clusters()));
  for (const auto& [name, op] : package.operators) {
    operators_.emplace(name, std::visit([](const auto& o) { return playable(o); }, op));
  }
  std::map<std::string, Value> values;
  for (const ProgramStep& step : package.program) {
    if (const auto* light = std::get_if<DirectLightStep>(&step))
      values[light->output] = {.direct_share = 1.0F};
    if (const auto* light = std::get_if<EnvironmentLightStep>(&step)) this->light(*light, values);
    if (const auto* application = std::get_if<ApplyStep>(&step)) {
      values[application->output] =
          apply(operators_.at(application->op), values.at(application->input));
    }
    if (const auto* addition = std::get_if<AddStep>(&step)) {
      values[addition->output] = add(values.at(addition->a), values.at(addition->b));
    }
    if (const auto* reconstruct = std::get_if<ReconstructStep>(&step)) {
      result_ = values.at(reconstruct->input);
    }
  }
}

bool PlayProgram::of_sky(int buffer) const {
  return std::ranges::any_of(
      steps_, [&](const Step& step) { return step.output == buffer && step.of_sky; });
}

int PlayProgram::emit(Step step) {
  step.of_sky = step.kind == Kind::kEnvironment || of_sky(step.a) || of_sky(step.b);
  step.output = new_buffer();
  steps_.push_back(step);
  return step.output;
}

int PlayProgram::sum(int a, int b) {
  if (a == kNothing || b == kNothing) return a == kNothing ? b : a;
  Step step;
  step.kind = Kind::kAdd;
  step.a = a;
  step.b = b;
  return emit(step);
}

int PlayProgram::whole(const Value& value) {
  const int rest = sum(value.sky, value.rest);
  if (value.direct_share == 0.0F) return rest;
  if (value.direct_share == 1.0F && rest == kNothing) return kNothing;
  Step step;
  step.kind = Kind::kAddDirect;
  step.a = rest;
  step.direct_share = value.direct_share;
  return emit(step);
}

PlayProgram::Value PlayProgram::apply(const PlayOperator& op, const Value& input) {
  Step step;
  step.op = &op;
  step.a = whole(input);
  step.layout = input.layout;
  Value value;
  if (const auto* projection = std::get_if<PlayProjection>(&op)) {
    step.kind = Kind::kProject;
    value.layout = &projection->layout();
  } else if (std::holds_alternative<PlayNear>(op)) {
    step.kind = Kind::kNear;
    step.scratch = new_buffer();
  } else {
    step.kind = Kind::kTransfer;
  }
  value.rest = emit(step);
  return value;
}

PlayProgram::Value PlayProgram::add(const Value& a, const Value& b) {
  return {a.direct_share + b.direct_share, sum(a.sky, b.sky), sum(a.rest, b.rest), a.layout};
}

/// Coefficients are copied into a buffer like any other; what they bring directly is kept apart, so
/// that pictures can show it with the lights'.
void PlayProgram::light(const EnvironmentLightStep& step, std::map<std::string, Value>& values) {
  Step copy;
  copy.kind = Kind::kEnvironment;
  Value coefficients;
  coefficients.rest = emit(copy);
  coefficients.layout = environment_layout_.get();
  values[step.coefficients] = coefficients;
  values[step.output] = {.sky = apply(operators_.at(step.op), coefficients).rest};
}

void PlayProgram::run(const Step& step, const MatrixF& direct_light, const MatrixF& environment,
                      unsigned threads, std::vector<MatrixF>& work) const {
  const auto buffer = [&](int index) -> MatrixF& { return work[static_cast<std::size_t>(index)]; };
  const MatrixF& input = step.a == kNothing ? direct_light : buffer(step.a);
  MatrixF& output = buffer(step.output);
  switch (step.kind) {
    case Kind::kEnvironment:
      if (environment.size() > 0) {
        output = environment;
      } else {
        output.setZero(3, environment_layout_->back());
      }
      return;
    case Kind::kProject:
      return std::get<PlayProjection>(*step.op).apply(input, samples_, threads, output);
    case Kind::kTransfer:
      return std::get<PlayTransfer>(*step.op).apply(input, *step.layout, samples_, threads, output);
    case Kind::kNear:
      return std::get<PlayNear>(*step.op).apply(input, threads, buffer(step.scratch), output);
    case Kind::kAdd:
      output = input + buffer(step.b);
      return;
    case Kind::kAddDirect:
      output = step.direct_share * direct_light;
      if (step.a != kNothing) output += input;
      return;
  }
}

void PlayProgram::run(const MatrixF& direct_light, const MatrixF& environment, bool lights_changed,
                      unsigned threads, std::vector<MatrixF>& work, MatrixF& direct, MatrixF& sky,
                      MatrixF& indirect) const {
  work.resize(static_cast<std::size_t>(buffers_));
  for (const Step& step : steps_) {
    if (lights_changed || step.of_sky) run(step, direct_light, environment, threads, work);
  }
  const auto irradiance = [&](int buffer) {
    return work[static_cast<std::size_t>(buffer)].transpose();
  };
  if (lights_changed) direct = result_.direct_share * direct_light.transpose();
  if (result_.sky != kNothing) {
    sky = irradiance(result_.sky);
  } else {
    sky.resize(0, 3);
  }
  if (result_.rest == kNothing) {
    indirect.setZero(direct_light.cols(), 3);
  } else if (lights_changed || of_sky(result_.rest)) {
    indirect = irradiance(result_.rest);
  }
}

}  // namespace prt
