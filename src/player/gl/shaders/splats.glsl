// Which samples a pixel sees its light through, and how much of each: the elliptical kernels of
// domains/splats.cpp that reach it. Kept as long as the camera stands still. An entry holds a
// sample's index in its low 22 bits and its weight above them; 0 ends the list. OFF_PLANE and
// COMPATIBLE_COSINE are those of domains/samples.h.
layout(binding = 0) uniform sampler2D position_image;
layout(binding = 1) uniform usampler2D surface_image;
layout(binding = 2) uniform samplerBuffer positions;  // xyz, one over the radius
layout(binding = 3) uniform samplerBuffer normals;
layout(binding = 4) uniform usamplerBuffer cells;         // hash table: SplatCells
layout(binding = 5) uniform usamplerBuffer lists;         // samples, four to a texel
layout(binding = 6) uniform usamplerBuffer plain_cells;   // samples where they lie
layout(binding = 7) uniform usamplerBuffer plain_lists;
layout(location = 0) out uvec4 splats_0;
layout(location = 1) out uvec4 splats_1;
layout(location = 2) out uvec4 splats_2;

uniform float inverse_cell;
uniform uint slot_mask;
uniform float plain_inverse_cell;
uniform uint plain_slot_mask;
uniform float widest;    // reach of the largest kernel, m
uniform float smallest;  // weight that counts
uniform float fallback;  // m
uniform vec4 exponents;  // of kernels, along and across; one over the reach squared

const int kMost = 12;
const float kWeakKernel = 0.008;  // adds less than a hundredth to what a pixel sees
#ifdef WEAK_KERNELS
const float kFullCover = 1e30;
#else
const float kFullCover = 0.25;  // where kernels sum up to less, weak ones count, too
#endif
const float kLimit = float(1 << 20);  // as in splat_cells.cpp

uint entries[kMost];
float weights[kMost];
float total = 0.0;

int used = 0;

void forget() {
  used = 0;
  total = 0.0;
}

ivec3 cell_of(vec3 p, float inverse) {
  return ivec3(floor(clamp(p * inverse, -kLimit, kLimit - 1.0)));
}

// Texels of the list of a cell: begin and end.
ivec2 list_of(ivec3 cell, usamplerBuffer table, uint mask) {
  uvec3 c = uvec3(cell) & 0x1FFFFFu;
  uvec2 key = uvec2(c.x | (c.y << 21), (c.y >> 11) | (c.z << 10));
  uint hash = c.x * 0x9E3779B1u ^ c.y * 0x85EBCA77u ^ c.z * 0xC2B2AE3Du;
  uint slot = (hash ^ (hash >> 15)) & mask;
  uvec4 found = texelFetch(table, int(slot));
  while (found.z != 0xFFFFFFFFu && found.xy != key) {
    slot = (slot + 1u) & mask;
    found = texelFetch(table, int(slot));
  }
  return found.z == 0xFFFFFFFFu ? ivec2(0) : ivec2(found.zw);
}

float kernel(vec4 sample_position, vec3 n, vec3 position, vec3 normal) {
  float cosine = dot(n, normal);
  vec3 offset = (sample_position.xyz - position) * sample_position.w;
  float tilted = dot(offset, n + normal);
  float across2 = tilted * tilted / (2.0 + 2.0 * cosine);
  float along2 = dot(offset, offset) - across2;
  float edge = 1.0 - along2 * exponents.z;
  float weight = (2.0 * cosine - 1.0) * edge * edge * exp2(along2 * exponents.x + across2 * exponents.y);
  return cosine > 0.5 && edge > 0.0 ? weight : 0.0;
}

// Kernels that are not weak leave room for more; of all kernels the lightest go.
void keep(uint index, float weight) {
#ifdef WEAK_KERNELS
  for (bool full = used == kMost; full; full = false) {
    int lightest = 0;
    for (int k = 1; k < kMost; ++k) {
      if (weights[k] < weights[lightest]) lightest = k;
    }
    if (weights[lightest] < weight) {
      entries[lightest] = index;
      weights[lightest] = weight;
    }
  }
#endif
  if (used < kMost) {
    entries[used] = index;
    weights[used] = weight;
    ++used;
  }
}

void reach(uint index, vec3 position, vec3 normal, float least) {
  float weight = kernel(texelFetch(positions, int(index)), texelFetch(normals, int(index)).xyz,
                        position, normal);
  if (weight > least) {
    total += weight;
    keep(index, weight);
  }
}

void find_kernels(vec3 position, vec3 normal) {
  ivec2 list = list_of(cell_of(position, inverse_cell), cells, slot_mask);
  for (int q = list.x; q < list.y; ++q) {
    uvec4 four = texelFetch(lists, q);
    reach(four.x, position, normal, kWeakKernel);
    reach(four.y, position, normal, kWeakKernel);
    reach(four.z, position, normal, kWeakKernel);
    reach(four.w, position, normal, kWeakKernel);
  }
}

// VISIT(index) for every sample in the cells within a distance of a place. A macro, for GLSL hands no
// function to another.
#define FOR_ALL_WITHIN(distance, position, VISIT)                                \
  ivec3 low = cell_of(position - distance, plain_inverse_cell);                  \
  ivec3 high = cell_of(position + distance, plain_inverse_cell);                 \
  for (int z = low.z; z <= high.z; ++z) {                                        \
    for (int y = low.y; y <= high.y; ++y) {                                      \
      for (int x = low.x; x <= high.x; ++x) {                                    \
        ivec2 list = list_of(ivec3(x, y, z), plain_cells, plain_slot_mask);      \
        for (int q = list.x; q < list.y; ++q) {                                  \
          uvec4 four = texelFetch(plain_lists, q);                               \
          VISIT(four.x);                                                         \
          VISIT(four.y);                                                         \
          VISIT(four.z);                                                         \
          VISIT(four.w);                                                         \
        }                                                                        \
      }                                                                          \
    }                                                                            \
  }

// Where samples are sparse: all that the kernels have to say, from every cell in reach.
void find_weak_kernels(vec3 position, vec3 normal) {
  forget();
#define REACH(index) reach(index, position, normal, smallest)
  FOR_ALL_WITHIN(widest, position, REACH)
}

void nearer(uint index, vec3 position, vec3 normal, inout float best, inout uint nearest) {
  vec3 offset = texelFetch(positions, int(index)).xyz - position;
  if (dot(offset, offset) > fallback * fallback) return;
  if (dot(texelFetch(normals, int(index)).xyz, normal) < COMPATIBLE_COSINE) return;
  // squared_distance_off() of domains/samples.h.
  float height = dot(normal, offset);
  float squared = dot(offset, offset) + (OFF_PLANE * OFF_PLANE - 1.0) * height * height;
  if (squared < best || (squared == best && index < nearest)) {
    best = squared;
    nearest = index;
  }
}

// Where no kernel reaches: the nearest sample that faces the same way.
void find_nearest(vec3 position, vec3 normal) {
  float best = 1e38;
  uint nearest = 0xFFFFFFFFu;
#define NEARER(index) nearer(index, position, normal, best, nearest)
  FOR_ALL_WITHIN(fallback, position, NEARER)
  if (nearest != 0xFFFFFFFFu) keep(nearest, 1.0);
}

uint entry(int k) {
  uint weight = uint(clamp(1023.0 * weights[k] + 0.5, 1.0, 1023.0));
  return k < used ? entries[k] | (weight << 22) : 0u;
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 position = texelFetch(position_image, pixel, 0);
  vec3 normal = surface_normal(texelFetch(surface_image, pixel, 0));
  forget();
  // Loops where ifs would do: a software renderer skips a loop that nobody enters, but runs every
  // branch.
  for (bool once = position.w > 0.0; once; once = false) {
    find_kernels(position.xyz, normal);
    for (bool sparse = total < kFullCover; sparse; sparse = false) {
      find_weak_kernels(position.xyz, normal);
    }
    for (bool none = used == 0; none; none = false) find_nearest(position.xyz, normal);
  }
  splats_0 = uvec4(entry(0), entry(1), entry(2), entry(3));
  splats_1 = uvec4(entry(4), entry(5), entry(6), entry(7));
  splats_2 = uvec4(entry(8), entry(9), entry(10), entry(11));
}
