// A small package whose answers are known in closed form: an empty box with samples on a grid on
// its six walls, one cluster per wall.
#pragma once

#include "package/package.h"

namespace prt::test {

struct SyntheticRoom {
  Vec3f size = Vec3f(4.0F, 3.0F, 5.0F);    ///< the box spans [0, size], seen from inside
  int samples_per_edge = 12;               ///< per wall: its square
  int directions = 64;                     ///< of the depth buffers; 0: no shadows
  Vec3f albedo = Vec3f(0.5F, 0.5F, 0.5F);  ///< of the furnace-like transfer
  std::uint32_t channels = 3;
  int bits = 32;  ///< of the quantised matrices
};

/// Program e = direct light; c = integral of e over each cluster; i = ρ/(1−ρ) times the mean of e
/// over the box; sum. Depth buffers hold the exact distance to the walls in full rank;
/// between their directions the soft test still shadows a little near the edges.
Package synthetic_room(const SyntheticRoom& room = {});

/// Lets every cluster of a synthetic room see everything up to the room's walls: five each.
void see_up_to_walls(Package& package, const Vec3f& size);

/// Adds near transfer to a synthetic room: sample r gets a quarter of what sample (r + 7) mod n and
/// a half of what sample (r + 50) mod n sends back; albedo 0.2, 0.4, 0.8, or 0.4 for one channel.
void add_near(Package& package, std::uint32_t channels = 3);

/// Adds an environment of that order to a synthetic room, as if its walls let all of it in from the
/// front: unshadowed transfer at each sample, and a bounced tenth, fifth and half (or a fifth, for
/// one channel) of the mean over its cluster. With `reflected`, the room's own transfer sends on
/// what the environment brings directly, too.
void add_environment(Package& package, int order, std::uint32_t channels = 3,
                     bool reflected = false);

/// The room's geometry, with every feature that a package has to carry: two materials out of order,
/// a textured alpha-masked quad in the middle, camera, point, spot and directional light.
Scene rich_scene(const Vec3f& size);

/// Adds a parallelogram that faces u × v.
void add_quad(Scene& scene, const Vec3f& corner, const Vec3f& u, const Vec3f& v,
              std::uint32_t material, std::uint32_t surface);

/// A PNG of 2 × 2 pixels: red, green, blue, white.
std::vector<std::byte> tiny_png();

}  // namespace prt::test
