// Averages the samples of each pixel.
layout(binding = 0) uniform sampler2D image;
layout(location = 0) out vec4 colour_out;

uniform int side;

void main() {
  ivec2 first = ivec2(gl_FragCoord.xy) * side;
  vec4 sum = vec4(0);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) sum += texelFetch(image, first + ivec2(x, y), 0);
  }
  colour_out = sum / float(side * side);
}
