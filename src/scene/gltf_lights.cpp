#include "scene/gltf_lights.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

#include "base/log.h"

namespace prt::gltf {
namespace {

/// Luminous efficacy at 555 nm: glTF's candela and lux to W/sr and W/m².
constexpr double kLumensPerWatt = 683.0;

/// A node's direction in the world, from one along an axis of its own.
Vec3f world_direction(const WorldNode& node, const Eigen::Vector3d& local, const Vec3f& fallback) {
  const Eigen::Vector3d direction = node.linear() * local;
  if (!direction.allFinite() || !(direction.stableNorm() > 0.0)) return fallback;
  return direction.stableNormalized().cast<float>();
}

Vec3f world_position(const WorldNode& node) {
  const Vec3f position = node.to_world.topRightCorner<3, 1>().cast<float>();
  if (!position.allFinite()) node.json.fail("its position is not finite");
  return position;
}

void read_spot(const Value& json, SceneLight& light) {
  const std::optional<Value> spot = json.find("spot");
  const double inner = spot ? spot->number_or("innerConeAngle", 0.0) : 0.0;
  const double outer = spot ? spot->number_or("outerConeAngle", EIGEN_PI / 4.0) : EIGEN_PI / 4.0;
  if (inner < 0.0 || inner >= outer || outer > EIGEN_PI / 2.0 + 1e-6) {
    json.fail("its cone angles must satisfy 0 <= inner < outer <= pi/2");
  }
  light.inner_angle = static_cast<float>(inner);
  light.outer_angle = static_cast<float>(outer);
}

SceneLight read_light(const Value& json, const WorldNode& node) {
  SceneLight light;
  light.name = json.text_or("name", "");
  const std::string type = json["type"].text();
  if (type == "point") {
    light.kind = SceneLight::Kind::kPoint;
  } else if (type == "directional") {
    light.kind = SceneLight::Kind::kSun;
  } else if (type == "spot") {
    light.kind = SceneLight::Kind::kSpot;
    read_spot(json, light);
  } else {
    json["type"].fail(fmt::format("'{}' is not point, spot or directional", type));
  }
  Eigen::Vector3d colour = Eigen::Vector3d::Ones();
  if (const std::optional<Value> member = json.find("color")) {
    colour = Eigen::Map<const Eigen::Vector3d>(member->numbers(3).data());
  }
  const double intensity = json.number_or("intensity", 1.0);
  light.intensity = (intensity / kLumensPerWatt * colour).cast<float>();
  if (!light.intensity.allFinite() || light.intensity.minCoeff() < 0.0F) {
    json.fail("its intensity and color must be finite and not negative");
  }
  light.position = world_position(node);
  light.direction = world_direction(node, -Eigen::Vector3d::UnitZ(), -Vec3f::UnitZ());
  return light;
}

SceneCamera read_camera(const Value& json, const WorldNode& node) {
  SceneCamera camera;
  camera.eye = world_position(node);
  camera.target = camera.eye + world_direction(node, -Eigen::Vector3d::UnitZ(), -Vec3f::UnitZ());
  camera.up = world_direction(node, Eigen::Vector3d::UnitY(), Vec3f::UnitY());
  if (const std::optional<Value> perspective = json.find("perspective")) {
    const double fov = (*perspective)["yfov"].number();
    if (!(fov > 0.0) || fov >= EIGEN_PI) perspective->fail("yfov must lie between 0 and pi");
    camera.vertical_fov = static_cast<float>(fov);
  }
  return camera;
}

}  // namespace

void load_lights_and_camera(const Document& document, const std::vector<WorldNode>& nodes,
                            Scene& scene) {
  const Value root = document.root();
  const std::optional<Value> extensions = root.find("extensions");
  const std::optional<Value> lights =
      extensions ? extensions->find("KHR_lights_punctual") : std::nullopt;
  for (const WorldNode& node : nodes) {
    if (const std::optional<Value> camera = node.json.find("camera")) {
      const std::uint32_t index = camera->index(root.count_of("cameras"), "cameras");
      if (!scene.camera) scene.camera = read_camera(root.element("cameras", index), node);
    }
    const std::optional<Value> of_node = node.json.find("extensions");
    const std::optional<Value> holder =
        of_node ? of_node->find("KHR_lights_punctual") : std::nullopt;
    if (!holder) continue;
    const std::uint32_t index =
        (*holder)["light"].index(lights ? lights->count_of("lights") : 0, "lights");
    scene.lights.push_back(read_light(lights->element("lights", index), node));
  }
  if (!scene.lights.empty()) {
    log::info("{}: {} lights; candela and lux divided by {} lm/W", document.name(),
              scene.lights.size(), kLumensPerWatt);
  }
}

}  // namespace prt::gltf
