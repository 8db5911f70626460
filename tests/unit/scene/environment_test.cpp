#include "scene/environment.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "base/error.h"
#include "base/random.h"
#include "support/exr_writer.h"

namespace prt {
namespace {

constexpr double kPiD = 3.14159265358979323846;
// Sums over half a million cells, values in float.
constexpr double kFloat = 1e-5;

std::filesystem::path write(const std::string& name, const std::string& bytes) {
  const auto path = std::filesystem::temp_directory_path() /
                    ("prt_environment_" + std::to_string(getpid()) + "_" + name);
  std::ofstream(path, std::ios::binary)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return path;
}

/// A Radiance picture without run lengths; values are powers of two or 0.
std::string hdr(int width, int height, const std::function<Vec3f(int x, int y)>& value) {
  std::string out = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " + std::to_string(height) + " +X " +
                    std::to_string(width) + "\n";
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Vec3f v = value(x, y);
      const float largest = v.maxCoeff();
      int exponent = 0;
      if (largest > 0.0F) std::frexp(largest, &exponent);
      for (int c = 0; c < 3; ++c) {
        out += static_cast<char>(static_cast<int>(std::ldexp(v[c], 8 - exponent)));
      }
      out += static_cast<char>(largest > 0.0F ? exponent + 128 : 0);
    }
  }
  return out;
}

/// ∫ L dω, and of L times the direction.
Vec3d integral(const Environment& environment, const Vec3d& along = Vec3d::Zero()) {
  Vec3d sum = Vec3d::Zero();
  environment.visit(256, [&](const Vec3d& d, double solid_angle, const Vec3f& radiance) {
    const double weight = along.isZero() ? 1.0 : std::max(0.0, along.dot(d));
    sum += solid_angle * weight * radiance.cast<double>();
  });
  return sum;
}

TEST(Environment, OfAConstantSkyFillsTheSphere) {
  const Environment sky = parse_environment("sky:1,2,0.5");
  EXPECT_NEAR(integral(sky).x(), 4.0 * kPiD, 1e-9);
  EXPECT_NEAR(integral(sky).y(), 8.0 * kPiD, 1e-9);
  EXPECT_NEAR(integral(sky, Vec3d::UnitX()).x(), kPiD, 1e-4);
  EXPECT_EQ(sky.radiance(Vec3f(0.6F, -0.8F, 0.0F)), Vec3f(1, 2, 0.5F));
}

TEST(Environment, OfTheTutorialHasItsTwoLobes) {
  const Environment lobes = parse_environment("lobes:2,0,1");
  EXPECT_NEAR(lobes.radiance(Vec3f::UnitY()).x(), 2.0, 2e-2);  // one cell off the pole
  const Vec3f second(std::sin(2.5F), 0.0F, std::cos(2.5F));
  EXPECT_NEAR(lobes.radiance(second).x(), 2.0, 2e-2);
  EXPECT_EQ(lobes.radiance(-Vec3f::UnitY()), Vec3f::Zero());
  // ∫ max(0, a cos − b) dω = 2π (a/2 (1 − c²) − b (1 − c)), c = b / a, once for either lobe.
  const auto lobe = [](double a, double b) {
    const double c = b / a;
    return 2.0 * kPiD * (0.5 * a * (1.0 - c * c) - b * (1.0 - c));
  };
  const double expected = 2.0 * (lobe(5.0, 4.0) + lobe(4.0, 3.0));
  EXPECT_NEAR(integral(lobes).x(), expected, 1e-4 * expected);
  EXPECT_NEAR(integral(lobes).z(), 0.5 * expected, 1e-4 * expected);
}

TEST(Environment, OfADiscHasItsSolidAngle) {
  for (const double degrees : {1.0, 5.0, 40.0}) {
    const Environment disc =
        parse_environment("disc:0.3,-0.7,0.2:3,0,0:" + std::to_string(degrees));
    const double expected = 3.0 * 2.0 * kPiD * (1.0 - std::cos(degrees * kPiD / 180.0));
    EXPECT_NEAR(integral(disc).x(), expected, 0.01 * expected) << degrees;
    EXPECT_EQ(disc.radiance(-Vec3f(0.3F, -0.7F, 0.2F).normalized()).x(), 3.0F);
  }
}

TEST(Environment, MapsHaveTheirMiddleAheadAndTheirTopAbove) {
  // Four columns, two rows: the upper left cell lies above, between +Z and −X.
  const auto value = [](int x, int y) {
    return y == 0 ? Vec3f(std::ldexp(1.0F, x), 0, 0) : Vec3f(0, 1, 0);
  };
  const auto file = write("map.hdr", hdr(4, 2, value));
  const Environment map = parse_environment(file.string());
  EXPECT_EQ(map.radiance(Vec3f(-1, 1, 1).normalized()).x(), 1.0F);
  EXPECT_EQ(map.radiance(Vec3f(-1, 1, -1).normalized()).x(), 2.0F);
  EXPECT_EQ(map.radiance(Vec3f(1, 1, -1).normalized()).x(), 4.0F);
  EXPECT_EQ(map.radiance(Vec3f(1, 1, 1).normalized()).x(), 8.0F);
  EXPECT_EQ(map.radiance(Vec3f(1, -1, 1).normalized()), Vec3f(0, 1, 0));
  EXPECT_NEAR(integral(map).x(), 15.0 * kPiD / 2.0, kFloat);
  std::filesystem::remove(file);
}

TEST(Environment, ProbesHaveTheirMiddleAtZAndBehindAtTheRim) {
  // Left half red, right half green, a blue middle.
  constexpr int kSide = 64;
  const auto value = [](int x, int y) {
    const bool middle = std::hypot(x - 31.5, y - 31.5) < 8.0;
    if (middle) return Vec3f(0, 0, 1);
    return y < 32 ? Vec3f(2, 0, 0) : x < 32 ? Vec3f(1, 0, 0) : Vec3f(0, 1, 0);
  };
  const auto file = write("probe.hdr", hdr(kSide, kSide, value));
  const Environment probe = parse_environment("probe:" + file.string());
  EXPECT_EQ(probe.radiance(Vec3f(0.02F, 0, 1).normalized()), Vec3f(0, 0, 1));
  EXPECT_EQ(probe.radiance(Vec3f(0, 1, 0)), Vec3f(2, 0, 0)) << "up is up";
  EXPECT_EQ(probe.radiance(Vec3f(-1, -0.1F, 0).normalized()), Vec3f(1, 0, 0)) << "−X to the left";
  EXPECT_EQ(probe.radiance(Vec3f(1, -0.1F, 0).normalized()), Vec3f(0, 1, 0));
  // Solid angle of a probe's pixel: its area in angles, times sin φ / φ (Debevec).
  double blue = 0.0;
  for (int x = 0; x < kSide; ++x) {
    for (int y = 0; y < kSide; ++y) {
      const double angle = 2.0 * kPiD * std::hypot(x - 31.5, y - 31.5) / kSide;
      const double area = std::pow(2.0 * kPiD / kSide, 2);
      if (value(x, y).z() > 0.0F) blue += area * std::sin(angle) / angle;
    }
  }
  EXPECT_NEAR(integral(probe).z(), blue, 0.01 * blue);
  std::filesystem::remove(file);
}

TEST(Environment, SamplesItsRadianceAndNothingElse) {
  for (const char* spec : {"lobes:1,1,1", "gradient:1,2,3:4,4,4:0,0,0", "disc:0,-1,0.5:9,9,9:3"}) {
    const Environment environment = parse_environment(spec).turned(30.0);
    const Vec3d n = Vec3d(0.3, 0.8, -0.4).normalized();
    constexpr int kSide = 256;
    Vec3d sum = Vec3d::Zero();
    for (int i = 0; i < kSide * kSide; ++i) {
      const float u = (static_cast<float>(i % kSide) + 0.5F) / kSide;
      const float v = (static_cast<float>(i / kSide) + 0.5F) / kSide;
      const IncidentLight light = environment.sample(u, v);
      ASSERT_TRUE(std::isinf(light.distance) && std::abs(light.to_light.norm() - 1.0F) < 1e-5F);
      sum += std::max(0.0, n.dot(light.to_light.cast<double>())) * light.irradiance.cast<double>() /
             (kSide * kSide);
    }
    const Vec3d expected = integral(environment, n);
    EXPECT_LT((sum - expected).norm(), 2e-3 * expected.norm()) << spec;
  }
  EXPECT_EQ(parse_environment("sky:0,0,0").sample(0.5F, 0.5F).irradiance, Vec3f::Zero());
}

TEST(Environment, TurnsCounterClockwiseSeenFromAbove) {
  const Environment lobes = parse_environment("lobes:1,1,1");
  const Environment turned = lobes.turned(90.0);  // takes +Z to +X
  for (const Vec3f& d :
       {Vec3f(0.1F, 0.2F, 1.0F), Vec3f(0.6F, 0.0F, -0.8F), Vec3f(-0.7F, 0.1F, 0.3F)}) {
    const Vec3f to(d.z(), d.y(), -d.x());
    EXPECT_EQ(turned.radiance(to.normalized()), lobes.radiance(d.normalized()));
  }
  EXPECT_NEAR((integral(turned, Vec3d::UnitX()) - integral(lobes, Vec3d::UnitZ())).norm(), 0.0,
              1e-4);
}

TEST(Environment, RefusesRubbish) {
  for (const char* spec : {"", "sky", "sky:", "sky:1,2", "sky:-1,0,0", "sky:1,1,1:2", "sky:nan,0,0",
                           "gradient:1,1,1", "lobes:1", "disc:0,0,0:1,1,1:5", "disc:0,1,0:1,1,1:0",
                           "disc:0,1,0:1,1,1:91", "map:", "probe:", "cloud.png"}) {
    EXPECT_THROW(static_cast<void>(parse_environment(spec)), UserError) << spec;
  }
  EXPECT_THROW(static_cast<void>(parse_environment("missing.hdr")), UserError);
}

constexpr std::array kCompressions = {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION,
                                      Imf::ZIPS_COMPRESSION, Imf::ZIP_COMPRESSION,
                                      Imf::PIZ_COMPRESSION};

test::ExrWriter exr(Imf::Compression compression, Imf::PixelType type) {
  test::ExrWriter writer;
  writer.width = 40;
  writer.height = 20;
  writer.compression = compression;
  writer.type = type;
  writer.first_line = -3;
  writer.value = [](const std::string& channel, int x, int y) {
    const float v = std::ldexp(1.0F, (x / 4 + y) % 8 - 3);
    return channel == "R" ? v : channel == "G" ? 2.0F * v : channel == "B" ? 0.0F : v;
  };
  return writer;
}

TEST(ExrImage, ReadsEveryCompressionAndType) {
  for (const Imf::Compression compression : kCompressions) {
    for (const Imf::PixelType type : {Imf::HALF, Imf::FLOAT}) {
      const test::ExrWriter writer = exr(compression, type);
      const auto file = write("map.exr", writer.encode());
      const Environment map = parse_environment("map:" + file.string());
      ASSERT_EQ(map.width(), 40);
      ASSERT_EQ(map.height(), 20);
      int cell = 0;
      map.visit(1, [&](const Vec3d&, double, const Vec3f& radiance) {
        const float expected = writer.value("R", cell % 40, cell / 40);
        EXPECT_EQ(radiance, Vec3f(expected, 2.0F * expected, 0.0F)) << compression << " " << type;
        ++cell;
      });
      std::filesystem::remove(file);
    }
  }
}

TEST(ExrImage, TakesNegativeRadianceForNone) {
  test::ExrWriter writer = exr(Imf::PIZ_COMPRESSION, Imf::FLOAT);
  writer.value = [](const std::string& channel, int, int) { return channel == "R" ? -1.0F : 2.0F; };
  const auto file = write("negative.exr", writer.encode());
  const Environment map = parse_environment("map:" + file.string());
  EXPECT_EQ(map.radiance(Vec3f::UnitX()), Vec3f(0, 2, 2));
  std::filesystem::remove(file);
}

TEST(ExrImage, ReadsLuminanceAsGrey) {
  test::ExrWriter writer = exr(Imf::ZIP_COMPRESSION, Imf::FLOAT);
  writer.channels = {"Y"};
  const auto file = write("grey.exr", writer.encode());
  const Vec3f top =
      parse_environment("map:" + file.string()).radiance(Vec3f(-0.01F, 1, 0.001F).normalized());
  EXPECT_EQ(top.x(), top.y());
  EXPECT_GT(top.z(), 0.0F);
  std::filesystem::remove(file);
}

/// Reads a damaged file: it is refused in one line, or what is read is sound.
void expect_refused_or_sound(const std::string& bytes, const std::string& name) {
  const auto file = write(name, bytes);
  try {
    const Environment map = parse_environment("map:" + file.string());
    map.visit(1, [](const Vec3d&, double, const Vec3f& radiance) {
      ASSERT_TRUE(radiance.allFinite() && radiance.minCoeff() >= 0.0F);
    });
  } catch (const UserError& e) {
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find(file.string()), std::string::npos) << e.what();
  }
  std::filesystem::remove(file);
}

TEST(ExrImage, SurvivesEveryCutAndManyFlips) {
  for (const Imf::Compression compression : kCompressions) {
    const std::string whole = exr(compression, Imf::HALF).encode();
    for (std::size_t size = 0; size < whole.size(); size += 1 + size / 40) {
      const auto file = write("cut.exr", whole.substr(0, size));
      EXPECT_THROW(static_cast<void>(parse_environment("map:" + file.string())), UserError) << size;
      std::filesystem::remove(file);
    }
    for (std::uint64_t i = 0; i < 400; ++i) {
      Random random(91, i);
      std::string flipped = whole;
      const std::size_t at =
          random.below(static_cast<std::uint32_t>(i % 2 == 0 ? 300 : whole.size()));
      flipped[at] = static_cast<char>(flipped[at] ^ (1 << random.below(8)));
      expect_refused_or_sound(flipped, "flipped.exr");
    }
  }
}

TEST(HdrImage, SurvivesCutsAndFlips) {
  const std::string whole = hdr(16, 8, [](int x, int y) { return Vec3f(1, x > y ? 1 : 0, 2); });
  for (std::uint64_t i = 0; i < 400; ++i) {
    Random random(92, i);
    std::string flipped = whole;
    const std::size_t at = random.below(static_cast<std::uint32_t>(i % 2 == 0 ? 60 : whole.size()));
    flipped[at] = static_cast<char>(flipped[at] ^ (1 << random.below(8)));
    expect_refused_or_sound(flipped, "flipped.hdr");
    expect_refused_or_sound(whole.substr(0, at), "cut.hdr");
  }
}

/// Why a picture is refused; empty if it is not.
std::string refusal(const std::string& bytes) {
  const auto file = write("refused.exr", bytes);
  std::string why;
  try {
    static_cast<void>(parse_environment("map:" + file.string()));
  } catch (const UserError& e) {
    why = e.what();
  }
  std::filesystem::remove(file);
  return why;
}

TEST(ExrImage, RefusesWhatItCannotReadByName) {
  test::ExrWriter other = exr(Imf::NO_COMPRESSION, Imf::FLOAT);
  other.channels = {"A", "Z"};
  EXPECT_NE(refusal(other.encode()).find("neither channels R, G and B nor Y"), std::string::npos);
  std::string unknown = exr(Imf::NO_COMPRESSION, Imf::FLOAT).encode();
  const std::string compression = std::string("compression\0compression\0\1\0\0\0", 28);
  unknown[unknown.find(compression) + compression.size()] = 42;
  EXPECT_NE(refusal(unknown), "");
  // A picture of two thousand million pixels in a few bytes.
  std::string huge = exr(Imf::NO_COMPRESSION, Imf::FLOAT).encode();
  const std::size_t box = huge.find(std::string("dataWindow\0box2i\0", 17)) + 21;
  for (const std::size_t corner : {8U, 12U}) {
    huge.replace(box + corner, 4, std::string("\x00\xb0\x00\x00", 4));
  }
  EXPECT_NE(refusal(huge), "");
  std::string parts = exr(Imf::NO_COMPRESSION, Imf::FLOAT).encode();
  parts[5] = static_cast<char>(parts[5] | 0x10);  // says that it has several
  EXPECT_NE(refusal(parts), "");
  test::ExrWriter bad = exr(Imf::NO_COMPRESSION, Imf::FLOAT);
  bad.value = [](const std::string&, int x, int) { return x == 3 ? std::nanf("") : 1.0F; };
  const auto bad_file = write("nan.exr", bad.encode());
  EXPECT_THROW(static_cast<void>(parse_environment("map:" + bad_file.string())), UserError);
  std::filesystem::remove(bad_file);
}

}  // namespace
}  // namespace prt
