// The text form that lights and environments share on the command line: name:numbers:numbers…
// Internal to scene/.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/types.h"

namespace prt {

struct SpecForm {
  std::string_view name;
  std::string_view text;            ///< as a user should type it
  std::vector<std::size_t> counts;  ///< numbers in each field; empty: one field that is no number
};

/// A SPEC taken apart; knows what to say when it is wrong.
class SpecFields {
 public:
  /// `what` is in front of every message: "light". Throws UserError unless the text has one of the
  /// forms.
  SpecFields(std::string_view what, std::string_view spec, std::span<const SpecForm> forms);

  /// Number of the form.
  [[nodiscard]] std::size_t form() const { return form_; }
  /// What follows the name of a form that has no numbers.
  [[nodiscard]] const std::string& rest() const { return rest_; }
  [[nodiscard]] Vec3d place(std::size_t field) const {
    return {fields_[field][0], fields_[field][1], fields_[field][2]};
  }
  [[nodiscard]] Vec3f vector(std::size_t field) const { return place(field).cast<float>(); }
  [[nodiscard]] float number(std::size_t field, std::size_t index = 0) const {
    return static_cast<float>(fields_[field][index]);
  }
  /// Not negative.
  [[nodiscard]] Vec3f colour(std::size_t field) const;
  [[nodiscard]] Vec3f unit_direction(std::size_t field) const;

  [[noreturn]] void fail(const std::string& what) const;

 private:
  static constexpr std::size_t kNoForm = static_cast<std::size_t>(-1);
  [[nodiscard]] std::vector<double> numbers(std::string_view text, std::size_t count) const;

  std::string what_;
  std::string spec_;
  std::span<const SpecForm> forms_;
  std::size_t form_ = kNoForm;
  std::vector<std::vector<double>> fields_;
  std::string rest_;
};

}  // namespace prt
