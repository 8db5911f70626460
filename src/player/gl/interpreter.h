// Runs a package's program on the GL: its spaces are buffers, its steps compute passes, in the
// order of the program. Internal to player/gl.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "package/package.h"
#include "player/gl/light_pass.h"
#include "player/gl/operators.h"
#include "player/picture.h"

namespace prt::gl {

class Interpreter {
 public:
  /// Both must outlive it. Expects what validate() lets through.
  Interpreter(const Package& package, const SampleBuffers& samples);

  /// Light work of one light change: fills in `fields` for a picture that shows that. `environment`
  /// as for Evaluator::evaluate.
  void run(const LightTable& lights, const MatrixF& environment, const SampleFields& fields,
           Show show);
  /// The same light for a picture that shows something else.
  void show(const SampleFields& fields, Show show);

  /// Irradiance at the samples as the last run left it, n × 3.
  [[nodiscard]] MatrixF direct() const;
  [[nodiscard]] MatrixF sky() const;
  [[nodiscard]] MatrixF indirect() const;

 private:
  using Coefficients = const CoefficientLayout*;
  struct Value {
    SampleValue samples;
    const TexelBuffer* coefficients = nullptr;
    Coefficients layout = nullptr;
  };
  void plan(const EnvironmentLightStep& step);
  void plan(const ApplyStep& step);
  void plan(const AddStep& step);
  [[nodiscard]] TexelBuffer& space(const std::string& name, std::size_t texels);
  /// A buffer with the sum of two, either of which may be null; plans it if neither is.
  const TexelBuffer* sum(const TexelBuffer* a, const TexelBuffer* b, const std::string& name);
  /// The value in at most two parts, none of the environment's its own.
  SampleValue joined(const SampleValue& value, const std::string& name);
  /// The value in one buffer; plans the sum if it is in several.
  const TexelBuffer& whole(const Value& value, const std::string& name);
  Value apply(const ClusterProjection& projection, const ApplyStep& step);
  Value apply(const ClusterTransfer& transfer, const ApplyStep& step);
  Value apply(const NearTransfer& near, const ApplyStep& step);
  void set_environment(const MatrixF& environment);
  [[nodiscard]] MatrixF download(const TexelBuffer* buffer) const;

  const Package& package_;
  const SampleBuffers& samples_;
  LightPass light_;
  CombinePass combine_;
  Program to_fields_;
  TexelBuffer direct_;
  std::map<std::string, TexelBuffer> spaces_;
  std::map<std::string, Value> values_;
  std::map<std::string, std::unique_ptr<ProjectionPass>> projections_;
  std::map<std::string, std::unique_ptr<NearPass>> nears_;
  std::map<std::pair<std::string, Coefficients>, std::unique_ptr<TransferPass>> transfers_;
  std::vector<std::function<void()>> steps_;
  CoefficientLayout environment_layout_;
  TexelBuffer environment_;
  const TexelBuffer* indirect_ = nullptr;
  const TexelBuffer* sky_ = nullptr;
};

}  // namespace prt::gl
