#include "player/play_program.h"

namespace prt {

PlayProgram::PlayProgram(const Package& package) : samples_(package.samples) {
  for (const auto& [name, op] : package.operators) {
    operators_.emplace(name, std::visit([](const auto& o) { return playable(o); }, op));
  }
  std::map<std::string, Value> values;
  for (const ProgramStep& step : package.program) {
    if (const auto* light = std::get_if<DirectLightStep>(&step)) values[light->output] = {1.0F};
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

int PlayProgram::emit(Step step) {
  step.output = new_buffer();
  steps_.push_back(step);
  return step.output;
}

int PlayProgram::whole(const Value& value) {
  if (value.direct_share == 0.0F) return value.rest;
  if (value.direct_share == 1.0F && value.rest == kNothing) return kNothing;
  Step step;
  step.kind = Kind::kAddDirect;
  step.a = value.rest;
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
  Value sum{a.direct_share + b.direct_share, a.rest, a.layout};
  if (a.rest == kNothing) sum.rest = b.rest;
  if (a.rest == kNothing || b.rest == kNothing) return sum;
  Step step;
  step.kind = Kind::kAdd;
  step.a = a.rest;
  step.b = b.rest;
  sum.rest = emit(step);
  return sum;
}

void PlayProgram::run(const Step& step, const MatrixF& direct_light, unsigned threads,
                      std::vector<MatrixF>& work) const {
  const auto buffer = [&](int index) -> MatrixF& { return work[static_cast<std::size_t>(index)]; };
  const MatrixF& input = step.a == kNothing ? direct_light : buffer(step.a);
  MatrixF& output = buffer(step.output);
  switch (step.kind) {
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

void PlayProgram::run(const MatrixF& direct_light, unsigned threads, std::vector<MatrixF>& work,
                      MatrixF& direct, MatrixF& indirect) const {
  work.resize(static_cast<std::size_t>(buffers_));
  for (const Step& step : steps_) run(step, direct_light, threads, work);
  direct = result_.direct_share * direct_light.transpose();
  if (result_.rest == kNothing) {
    indirect.setZero(direct_light.cols(), 3);
  } else {
    indirect = work[static_cast<std::size_t>(result_.rest)].transpose();
  }
}

}  // namespace prt
