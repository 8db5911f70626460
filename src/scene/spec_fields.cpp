#include "scene/spec_fields.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "base/error.h"

namespace prt {
namespace {

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

/// "point:, sphere: or sun:"
std::string names(std::span<const SpecForm> forms) {
  std::string all;
  for (std::size_t i = 0; i < forms.size(); ++i) {
    if (i > 0) all += i + 1 == forms.size() ? " or " : ", ";
    all += fmt::format("{}:", forms[i].name);
  }
  return all;
}

}  // namespace

SpecFields::SpecFields(std::string_view what, std::string_view spec,
                       std::span<const SpecForm> forms)
    : what_(what), spec_(spec), forms_(forms) {
  const std::vector<std::string_view> parts = split(spec, ':');
  for (std::size_t i = 0; i < forms.size(); ++i) {
    if (forms[i].name == parts[0]) form_ = i;
  }
  if (form_ == kNoForm) fail("it must begin with " + names(forms));
  const std::vector<std::size_t>& counts = forms[form_].counts;
  if (counts.empty()) {
    if (parts.size() > 1) rest_ = spec.substr(parts[0].size() + 1);
    if (rest_.empty()) fail("nothing follows");
    return;
  }
  if (parts.size() != counts.size() + 1) {
    fail(fmt::format("{} fields after '{}:' expected, {} found", counts.size(), forms[form_].name,
                     parts.size() - 1));
  }
  for (std::size_t i = 0; i < counts.size(); ++i) {
    fields_.push_back(numbers(parts[i + 1], counts[i]));
  }
}

Vec3f SpecFields::colour(std::size_t field) const {
  if (vector(field).minCoeff() < 0.0F) fail("r,g,b must not be negative");
  return vector(field);
}

Vec3f SpecFields::unit_direction(std::size_t field) const {
  const Vec3d direction = vector(field).cast<double>();
  if (direction.isZero(0.0)) fail("the direction must not be zero");
  return direction.normalized().cast<float>();
}

void SpecFields::fail(const std::string& what) const {
  const std::string form = form_ == kNoForm ? "" : fmt::format("; expected {}", forms_[form_].text);
  throw UserError(fmt::format("{} '{}': {}{}", what_, spec_, what, form));
}

std::vector<double> SpecFields::numbers(std::string_view text, std::size_t count) const {
  const std::vector<std::string_view> parts = split(text, ',');
  if (parts.size() != count) {
    fail(fmt::format("'{}' should be {} numbers separated by commas", text, count));
  }
  std::vector<double> values;
  for (const std::string_view part : parts) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (error != std::errc() || end != part.data() + part.size() ||
        !std::isfinite(static_cast<float>(value))) {
      fail(fmt::format("'{}' is not a finite number", part));
    }
    values.push_back(value);
  }
  return values;
}

}  // namespace prt
