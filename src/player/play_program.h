// A package's program made ready to run again and again: spaces are buffers, steps calls in order,
// and what a step leaves unchanged is not copied. Internal to player/.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "package/package.h"
#include "player/play_operators.h"

namespace prt {

class PlayProgram {
 public:
  /// Keeps references to the package's samples and operators. Expects what validate() lets
  /// through.
  explicit PlayProgram(const Package& package);
  PlayProgram(const PlayProgram&) = delete;  // steps point into it
  PlayProgram& operator=(const PlayProgram&) = delete;
  PlayProgram(PlayProgram&&) = default;
  PlayProgram& operator=(PlayProgram&&) = delete;
  ~PlayProgram() = default;

  /// Runs the steps after the light steps on direct irradiance of lights at the samples (3 × n) and
  /// the environment's coefficients (3 × order², or empty: none). n × 3 each, `direct`, `sky` and
  /// `indirect` are what is reconstructed of light that comes straight from lights, straight from
  /// the environment, and all the rest. `work` holds the program's own values between steps; given
  /// again, nothing is allocated. Unless `lights_changed`, all that hangs on lights alone is still
  /// there from the run before.
  void run(const MatrixF& direct_light, const MatrixF& environment, bool lights_changed,
           unsigned threads, std::vector<MatrixF>& work, MatrixF& direct, MatrixF& sky,
           MatrixF& indirect) const;

 private:
  static constexpr int kNothing = -1;
  /// Irradiance in three parts: so many times direct light, a buffer of what came straight from the
  /// environment, and one of the rest. Coefficients are a rest with a layout.
  struct Value {
    float direct_share = 0.0F;
    int sky = kNothing;
    int rest = kNothing;
    const std::vector<std::uint32_t>* layout = nullptr;
  };
  enum class Kind { kEnvironment, kProject, kTransfer, kNear, kAdd, kAddDirect };
  struct Step {
    Kind kind = Kind::kAdd;
    const PlayOperator* op = nullptr;
    int a = kNothing;  ///< buffers
    int b = kNothing;
    int output = kNothing;
    int scratch = kNothing;
    float direct_share = 0.0F;
    const std::vector<std::uint32_t>* layout = nullptr;
    bool of_sky = false;  ///< the environment has a part in it
  };
  [[nodiscard]] bool of_sky(int buffer) const;
  int new_buffer() { return buffers_++; }
  /// Adds a step that writes a buffer of its own; that buffer.
  int emit(Step step);
  /// A buffer of the sum of two, either of which may be nothing.
  int sum(int a, int b);
  /// The value in one buffer; kNothing stands for direct light itself.
  int whole(const Value& value);
  Value apply(const PlayOperator& op, const Value& input);
  Value add(const Value& a, const Value& b);
  void light(const EnvironmentLightStep& step, std::map<std::string, Value>& values);
  void run(const Step& step, const MatrixF& direct_light, const MatrixF& environment,
           unsigned threads, std::vector<MatrixF>& work) const;

  const SampleSet& samples_;
  std::map<std::string, PlayOperator> operators_;
  std::unique_ptr<const std::vector<std::uint32_t>> environment_layout_;  // values point to it
  std::vector<Step> steps_;
  int buffers_ = 0;
  Value result_;
};

}  // namespace prt
