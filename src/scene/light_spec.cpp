// Light specifications of the command line.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <charconv>
#include <cmath>
#include <string>
#include <vector>

#include "base/error.h"
#include "scene/light.h"
#include "scene/scene.h"

namespace prt {
namespace {

constexpr float kRadiansPerDegree = kPi / 180.0F;

struct Form {
  std::string_view name;
  Light::Kind kind;
  std::string_view text;
  std::vector<std::size_t> counts;  ///< numbers in each field
};

const std::vector<Form>& forms() {
  static const std::vector<Form> all = {
      {"point", Light::Kind::kPoint, "point:x,y,z:r,g,b", {3, 3}},
      {"sphere", Light::Kind::kSphere, "sphere:x,y,z:r,g,b:radius", {3, 3, 1}},
      {"spot", Light::Kind::kSpot, "spot:x,y,z:dx,dy,dz:r,g,b:inner_deg,outer_deg", {3, 3, 3, 2}},
      {"quad", Light::Kind::kQuad, "quad:cx,cy,cz:ux,uy,uz:vx,vy,vz:r,g,b", {3, 3, 3, 3}},
      {"sun", Light::Kind::kSun, "sun:dx,dy,dz:r,g,b", {3, 3}},
  };
  return all;
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

/// A SPEC on its way to a Light; knows what to say when it is wrong.
class Spec {
 public:
  explicit Spec(std::string_view spec) : spec_(spec) {
    const std::vector<std::string_view> parts = split(spec, ':');
    for (const Form& form : forms()) {
      if (form.name == parts[0]) form_ = &form;
    }
    if (form_ == nullptr) fail("it must begin with point:, sphere:, spot:, quad: or sun:");
    if (parts.size() != form_->counts.size() + 1) {
      fail(fmt::format("{} fields after '{}:' expected, {} found", form_->counts.size(),
                       form_->name, parts.size() - 1));
    }
    for (std::size_t i = 0; i < form_->counts.size(); ++i) {
      fields_.push_back(numbers(parts[i + 1], form_->counts[i]));
    }
  }

  [[nodiscard]] Light::Kind kind() const { return form_->kind; }
  [[nodiscard]] Vec3d place(std::size_t field) const {
    return {fields_[field][0], fields_[field][1], fields_[field][2]};
  }
  [[nodiscard]] Vec3f vector(std::size_t field) const { return place(field).cast<float>(); }
  [[nodiscard]] float number(std::size_t field, std::size_t index = 0) const {
    return static_cast<float>(fields_[field][index]);
  }
  [[nodiscard]] Vec3f colour(std::size_t field) const {
    if (vector(field).minCoeff() < 0.0F) fail("r,g,b must not be negative");
    return vector(field);
  }
  [[nodiscard]] Vec3f unit_direction(std::size_t field) const {
    const Vec3d direction = vector(field).cast<double>();
    if (direction.isZero(0.0)) fail("the direction must not be zero");
    return direction.normalized().cast<float>();
  }

  [[noreturn]] void fail(const std::string& what) const {
    const std::string form = form_ == nullptr ? "" : fmt::format("; expected {}", form_->text);
    throw UserError(fmt::format("light '{}': {}{}", spec_, what, form));
  }

 private:
  [[nodiscard]] std::vector<double> numbers(std::string_view text, std::size_t count) const {
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

  std::string spec_;
  const Form* form_ = nullptr;
  std::vector<std::vector<double>> fields_;
};

void read_spot(const Spec& spec, Light& light) {
  light.direction = spec.unit_direction(1);
  light.intensity = spec.colour(2);
  const float inner = spec.number(3, 0);
  const float outer = spec.number(3, 1);
  if (inner < 0.0F || outer <= 0.0F || inner > outer || outer > 90.0F) {
    spec.fail("the angles must satisfy 0 <= inner <= outer <= 90 degrees and outer > 0");
  }
  light.inner_angle = inner * kRadiansPerDegree;
  light.outer_angle = outer * kRadiansPerDegree;
}

void read_quad(const Spec& spec, Light& light) {
  light.edge_u = spec.vector(1);
  light.edge_v = spec.vector(2);
  light.intensity = spec.colour(3);
  const float sine_scale = light.edge_u.norm() * light.edge_v.norm();
  const float area = light.edge_u.cross(light.edge_v).norm();
  if (!(area > 1e-6F * sine_scale) || !std::isfinite(area)) {
    spec.fail("the edges u and v must be finite and span an area");
  }
}

}  // namespace

Light WorldLight::in(const Vec3d& origin) const {
  Light moved = light;
  if (light.kind != Light::Kind::kSun) moved.position = relative_to(origin, position);
  return moved;
}

WorldLight parse_light(std::string_view text) {
  const Spec spec(text);
  WorldLight parsed;
  Light& light = parsed.light;
  light.kind = spec.kind();
  if (light.kind != Light::Kind::kSun) parsed.position = spec.place(0);
  switch (light.kind) {
    case Light::Kind::kPoint:
      light.intensity = spec.colour(1);
      break;
    case Light::Kind::kSphere:
      light.intensity = spec.colour(1);
      light.radius = spec.number(2);
      if (!(light.radius > 0.0F)) spec.fail("the radius must be positive");
      break;
    case Light::Kind::kSpot:
      read_spot(spec, light);
      break;
    case Light::Kind::kQuad:
      read_quad(spec, light);
      break;
    case Light::Kind::kSun:
      light.direction = spec.unit_direction(0);
      light.intensity = spec.colour(1);
      break;
  }
  return parsed;
}

std::vector<Light> lights_in(const Vec3d& origin, std::span<const WorldLight> lights) {
  std::vector<Light> placed;
  placed.reserve(lights.size());
  for (const WorldLight& light : lights) placed.push_back(light.in(origin));
  return placed;
}

}  // namespace prt
