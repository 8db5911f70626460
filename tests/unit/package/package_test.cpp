#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "base/error.h"
#include "base/random.h"
#include "package/read.h"
#include "package/write.h"
#include "unit/package/synthetic_package.h"

namespace prt {
namespace {

namespace fs = std::filesystem;
using test::synthetic_room;

/// 16-bit unit vectors are off by half an integer per component.
constexpr float kUnitRounding = 1.0F / 32767.0F;
/// Lights and camera pass through colour × strength and quaternions, in single precision.
constexpr float kRelativeRounding = 1e-5F;

class PackageFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("prt_package_test_" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  Package round_trip(const Package& package) {
    write_package(package, path());
    return read_package(path());
  }
  void write_bytes(std::span<const std::byte> bytes) {
    std::ofstream file(path(), std::ios::binary | std::ios::trunc);
    file.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  }
  /// Message of the UserError that reading ends in; empty if the file is sound.
  std::string complaint() {
    try {
      static_cast<void>(read_package(path()));
    } catch (const UserError& error) {
      return error.what();
    }
    return {};
  }
  [[nodiscard]] fs::path path() const { return folder_ / "room.prt.glb"; }

  fs::path folder_;
};

void expect_equal(const QuantisedMatrix& a, const QuantisedMatrix& b) {
  EXPECT_EQ(a.rows, b.rows);
  EXPECT_EQ(a.cols, b.cols);
  EXPECT_EQ(a.bits, b.bits);
  EXPECT_EQ(a.int8, b.int8);
  EXPECT_EQ(a.int16, b.int16);
  EXPECT_EQ(a.float32, b.float32);
  if (a.rows > 0 && a.cols > 0) {
    EXPECT_EQ(a.scales, b.scales);
  }
}

class RoundTrip : public PackageFile, public ::testing::WithParamInterface<int> {};
INSTANTIATE_TEST_SUITE_P(Bits, RoundTrip, ::testing::Values(8, 16, 32));

TEST_P(RoundTrip, KeepsEveryMatrixExactly) {
  const Package before = synthetic_room({.bits = GetParam()});
  const Package after = round_trip(before);
  ASSERT_TRUE(after.visibility);
  EXPECT_EQ(after.visibility->directions, before.visibility->directions);
  EXPECT_EQ(after.visibility->bound, before.visibility->bound);
  EXPECT_EQ(after.visibility->bias, before.visibility->bias);
  for (std::size_t c = 0; c < before.samples.clusters(); ++c) {
    expect_equal(after.visibility->clusters[c].mean, before.visibility->clusters[c].mean);
    expect_equal(after.visibility->clusters[c].basis, before.visibility->clusters[c].basis);
    expect_equal(after.visibility->clusters[c].coefficients,
                 before.visibility->clusters[c].coefficients);
  }
  const auto& projection = std::get<ClusterProjection>(before.operators.at("project"));
  const auto& projection_read = std::get<ClusterProjection>(after.operators.at("project"));
  const auto& transfer = std::get<ClusterTransfer>(before.operators.at("transfer"));
  const auto& transfer_read = std::get<ClusterTransfer>(after.operators.at("transfer"));
  EXPECT_EQ(transfer_read.channels, transfer.channels);
  for (std::size_t c = 0; c < before.samples.clusters(); ++c) {
    expect_equal(projection_read.blocks[c], projection.blocks[c]);
    EXPECT_EQ(transfer_read.receivers[c].senders, transfer.receivers[c].senders);
    expect_equal(transfer_read.receivers[c].left, transfer.receivers[c].left);
    expect_equal(transfer_read.receivers[c].right, transfer.receivers[c].right);
  }
}

TEST_F(PackageFile, KeepsNearTransfer) {
  for (const std::uint32_t channels : {1U, 3U}) {
    Package before = synthetic_room();
    test::add_near(before, channels);
    const Package after = round_trip(before);
    const auto& near = std::get<NearTransfer>(before.operators.at("near"));
    const auto& read = std::get<NearTransfer>(after.operators.at("near"));
    EXPECT_EQ(read.channels, channels);
    EXPECT_EQ(read.begin, near.begin);
    EXPECT_EQ(read.senders, near.senders);
    EXPECT_EQ(read.shares, near.shares);
    EXPECT_EQ(read.albedo, near.albedo);
  }
}

TEST_F(PackageFile, KeepsSamples) {
  const Package before = synthetic_room();
  const Package after = round_trip(before);
  EXPECT_EQ(after.samples.positions, before.samples.positions);
  EXPECT_EQ(after.samples.areas, before.samples.areas);
  EXPECT_EQ(after.samples.radii, before.samples.radii);
  EXPECT_EQ(after.samples.cluster_begin, before.samples.cluster_begin);
  ASSERT_EQ(after.samples.size(), before.samples.size());
  for (std::size_t i = 0; i < before.samples.size(); ++i) {
    EXPECT_LT((after.samples.normals[i] - before.samples.normals[i]).norm(), kUnitRounding);
    EXPECT_LT((after.samples.tangents[i] - before.samples.tangents[i]).norm(), kUnitRounding);
  }
}

TEST_F(PackageFile, SamplesStayOnTheirTriangles) {
  const Package before = synthetic_room();
  const Package after = round_trip(before);
  ASSERT_EQ(after.scene.triangles.size(), before.scene.triangles.size());
  for (std::size_t i = 0; i < before.samples.size(); ++i) {
    for (const auto& [u, v] : {std::pair{0.0F, 0.0F}, {1.0F, 0.0F}, {0.0F, 1.0F}}) {
      ASSERT_EQ(triangle_point(after.scene, after.samples.triangles[i], u, v),
                triangle_point(before.scene, before.samples.triangles[i], u, v));
    }
  }
}

TEST_F(PackageFile, KeepsMaterialsAndTextures) {
  const Package before = synthetic_room();
  const Package after = round_trip(before);
  for (std::size_t i = 0; i < before.samples.size(); ++i) {
    EXPECT_EQ(albedo_at(after.scene, after.samples.triangles[i], 0.3F, 0.3F),
              albedo_at(before.scene, before.samples.triangles[i], 0.3F, 0.3F));
  }
  ASSERT_EQ(after.scene.materials.size(), before.scene.materials.size());
  const Material& leaf = after.scene.materials[2];
  EXPECT_TRUE(leaf.alpha_mask);
  EXPECT_EQ(leaf.alpha_cutoff, 0.25F);
  EXPECT_TRUE(after.scene.materials[0].double_sided);
  ASSERT_EQ(after.scene.textures.size(), 1U);
  EXPECT_EQ(after.scene.textures[0].encoded, before.scene.textures[0].encoded);
  EXPECT_EQ(after.scene.textures[0].rgba, before.scene.textures[0].rgba);
  EXPECT_EQ(after.scene.textures[0].wrap_u, Texture::Wrap::kClamp);
  const auto last = static_cast<std::uint32_t>(before.scene.triangles.size() - 1);
  EXPECT_EQ(albedo_at(after.scene, last, 0.2F, 0.6F), albedo_at(before.scene, last, 0.2F, 0.6F));
}

TEST_F(PackageFile, KeepsCameraAndLights) {
  const Package before = synthetic_room();
  const Package after = round_trip(before);
  ASSERT_TRUE(after.scene.camera);
  const auto forward = [](const SceneCamera& c) -> Vec3f {
    return (c.target - c.eye).normalized();
  };
  EXPECT_EQ(after.scene.camera->eye, before.scene.camera->eye);
  EXPECT_TRUE(forward(*after.scene.camera).isApprox(forward(*before.scene.camera), 1e-5F));
  EXPECT_FLOAT_EQ(after.scene.camera->vertical_fov, before.scene.camera->vertical_fov);
  ASSERT_EQ(after.scene.lights.size(), before.scene.lights.size());
  for (std::size_t l = 0; l < before.scene.lights.size(); ++l) {
    const SceneLight& a = after.scene.lights[l];
    const SceneLight& b = before.scene.lights[l];
    EXPECT_EQ(a.kind, b.kind);
    EXPECT_EQ(a.name, b.name);
    EXPECT_TRUE(a.intensity.isApprox(b.intensity, kRelativeRounding)) << a.intensity.transpose();
    if (b.kind != SceneLight::Kind::kSun) {
      EXPECT_EQ(a.position, b.position);
    }
    if (b.kind != SceneLight::Kind::kPoint) {
      EXPECT_TRUE(a.direction.isApprox(b.direction, kRelativeRounding));
    }
  }
  EXPECT_FLOAT_EQ(after.scene.lights[1].inner_angle, 0.2F);
  EXPECT_FLOAT_EQ(after.scene.lights[1].outer_angle, 0.5F);
}

/// The JSON of a package, and its bytes with other JSON.
std::size_t json_bytes(std::span<const std::byte> package) {
  std::uint32_t size = 0;
  std::memcpy(&size, package.data() + 12, sizeof size);
  return size;
}
nlohmann::json json_of(std::span<const std::byte> package) {
  const auto* text = reinterpret_cast<const char*>(package.data()) + 20;
  return nlohmann::json::parse(text, text + json_bytes(package));
}
std::string with_json(std::span<const std::byte> package, std::string text) {
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::string file(reinterpret_cast<const char*>(package.data()), package.size());
  file.replace(20, json_bytes(package), text);
  const auto word = [&](std::size_t at, std::size_t value) {
    const auto narrow = static_cast<std::uint32_t>(value);
    std::memcpy(file.data() + at, &narrow, sizeof narrow);
  };
  word(8, file.size());
  word(12, text.size());
  return file;
}

TEST_F(PackageFile, KeepsScenesThatHaveAnOriginOfTheirOwn) {
  Package before = synthetic_room();
  // No float, and not what a loader would choose: the file's word counts.
  before.scene.origin = Vec3d(123456.7, -8.1e6, 0.3);
  const Package after = round_trip(before);
  EXPECT_EQ(after.scene.origin, before.scene.origin);
  EXPECT_EQ(after.samples.positions, before.samples.positions);
  for (std::size_t i = 0; i < before.samples.size(); ++i) {
    ASSERT_EQ(triangle_point(after.scene, after.samples.triangles[i], 1.0F, 0.0F),
              triangle_point(before.scene, before.samples.triangles[i], 1.0F, 0.0F));
  }
  EXPECT_EQ(after.scene.camera->eye, before.scene.camera->eye);
  EXPECT_EQ(after.scene.lights[0].position, before.scene.lights[0].position);
  EXPECT_EQ(encode_package(round_trip(after)), encode_package(after));
}

TEST_F(PackageFile, StandsWhereItWasForAnyViewer) {
  Package package = synthetic_room();
  EXPECT_FALSE(
      json_of(encode_package(package))["extensions"]["PRT_light_transfer"].contains("origin"));
  package.scene.origin = Vec3d(123456.7, -8.1e6, 0.3);
  const nlohmann::json json = json_of(encode_package(package));
  ASSERT_EQ(json["scenes"][0]["nodes"].size(), 1U);
  const nlohmann::json& root = json["nodes"][json["scenes"][0]["nodes"][0].get<std::size_t>()];
  EXPECT_EQ(root["translation"], (nlohmann::json{123456.7, -8.1e6, 0.3}));
  EXPECT_EQ(root["children"].size() + 1, json["nodes"].size()) << "mesh, camera and lights";
  EXPECT_EQ(json["extensions"]["PRT_light_transfer"]["origin"], root["translation"]);
}

TEST_F(PackageFile, RefusesHostileOrigins) {
  Package package = synthetic_room();
  package.scene.origin = Vec3d(123456.7, -8.1e6, 0.3);
  const std::vector<std::byte> sound = encode_package(package);
  const std::string text = json_of(sound).dump();
  const std::string origin = "\"origin\":[123456.7,-8100000.0,0.3]";
  ASSERT_NE(text.find(origin), std::string::npos);
  const auto write_origin = [&](const std::string& value) {
    std::string spoilt = text;
    spoilt =
        with_json(sound, spoilt.replace(text.find(origin), origin.size(), "\"origin\":" + value));
    write_bytes(std::as_bytes(std::span(spoilt)));
  };
  write_origin("[123456.7,-8100000.0,0.3]");
  EXPECT_EQ(complaint(), "");
  for (const char* value : {"null", "7", "\"here\"", "{}", "[]", "[1,2]", "[1,2,3,4]", "[1,2,null]",
                            "[1,2,\"3\"]", "[NaN,0,0]", "[1e999,0,0]", "[1e300,0,0]", "[0,0,-2e15]",
                            // Well-formed, and somewhere else than the geometry.
                            "[1e15,0,0]", "[0,0,0]", "[123456.7,-8100000.0,1.3]"}) {
    write_origin(value);
    EXPECT_NE(complaint().find("room.prt.glb"), std::string::npos) << value << ": " << complaint();
    EXPECT_EQ(complaint().find('\n'), std::string::npos) << complaint();
  }
}

TEST_F(PackageFile, KeepsErrorAndProvenance) {
  const Package before = synthetic_room();
  const Package after = round_trip(before);
  EXPECT_EQ(after.provenance, before.provenance);
  EXPECT_EQ(after.error, before.error);
}

TEST_F(PackageFile, EqualPackagesGiveEqualBytes) {
  EXPECT_EQ(encode_package(synthetic_room()), encode_package(synthetic_room()));
  const Package package = synthetic_room({.bits = 8});
  // Geometry is written in the order in which it is read: a second passage changes nothing there.
  const Package once = round_trip(package);
  EXPECT_EQ(encode_package(round_trip(once)), encode_package(once));
}

TEST_F(PackageFile, ClustersThatSeeEverythingHaveNoDepths) {
  Package package = synthetic_room();
  package.visibility->clusters[2] = {};
  const Package after = round_trip(package);
  EXPECT_EQ(after.visibility->clusters[2].mean.rows, 0U);
  EXPECT_EQ(after.visibility->clusters[3].basis.rows, 64U);
}

TEST_F(PackageFile, KeepsWalls) {
  Package package = synthetic_room();
  test::see_up_to_walls(package, test::SyntheticRoom().size);
  package.visibility->clusters[2].walls.resize(0, 4);
  const Package after = round_trip(package);
  for (std::size_t c = 0; c < package.visibility->clusters.size(); ++c) {
    EXPECT_EQ(after.visibility->clusters[c].walls, package.visibility->clusters[c].walls);
    EXPECT_EQ(after.visibility->clusters[c].mean.rows, 0U);
  }
}

TEST_F(PackageFile, OnlyWallsNeedANewReader) {
  const auto version = [](const Package& package) {
    const std::vector<std::byte> bytes = encode_package(package);
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::string key = "\"version\":";
    // The asset's version is a string.
    for (auto at = text.find(key); at != text.npos; at = text.find(key, at + 1)) {
      if (text[at + key.size()] != '"') return text[at + key.size()];
    }
    return '?';
  };
  Package package = synthetic_room();
  EXPECT_EQ(version(package), '1');
  test::see_up_to_walls(package, test::SyntheticRoom().size);
  EXPECT_EQ(version(package), '2');
}

TEST_F(PackageFile, RefusesCountsOfWallsThatDoNotFit) {
  Package package = synthetic_room();
  test::see_up_to_walls(package, test::SyntheticRoom().size);
  const std::vector<std::byte> sound = encode_package(package);
  const std::string counts = "\"wall_counts\":[5,5,5,5,5,5]";
  for (const char* hostile : {"\"wall_counts\":[6,5,5,5,5,5]", "\"wall_counts\":[4,5,5,5,5,5]",
                              "\"wall_counts\":[5,5,5,5,5  ]", "\"wall_counts\":[-5,5,5,5,5,]",
                              "\"wall_counts\":7            "}) {
    std::vector<std::byte> bytes = sound;
    auto* text = reinterpret_cast<char*>(bytes.data());
    const auto at = std::string_view(text, bytes.size()).find(counts);
    ASSERT_NE(at, std::string_view::npos);
    std::copy_n(hostile, counts.size(), text + at);
    write_bytes(bytes);
    EXPECT_NE(complaint(), "") << hostile;
  }
}

TEST_F(PackageFile, RefusesOtherVersions) {
  std::vector<std::byte> bytes = encode_package(synthetic_room());
  const std::string version = "\"version\":1,";  // the extension's: the asset's is a string
  auto* text = reinterpret_cast<char*>(bytes.data());
  const auto at = std::string_view(text, bytes.size()).find(version);
  ASSERT_NE(at, std::string_view::npos);
  text[at + version.size() - 2] = '7';
  write_bytes(bytes);
  EXPECT_NE(complaint().find("newer program"), std::string::npos) << complaint();
}

TEST_F(PackageFile, RefusesForeignAndTruncatedFiles) {
  EXPECT_NE(complaint(), "");  // no file at all
  const std::vector<std::byte> bytes = encode_package(synthetic_room({.samples_per_edge = 3}));
  for (const double share : {0.0, 0.0001, 0.1, 0.5, 0.999}) {
    write_bytes(std::span(bytes).first(static_cast<std::size_t>(share * double(bytes.size()))));
    EXPECT_NE(complaint(), "") << share;
  }
  write_bytes(test::tiny_png());
  EXPECT_NE(complaint(), "");
}

/// Each entry spoils one thing that validate() has to find.
using Spoil = void (*)(Package&);
class Unsound : public ::testing::TestWithParam<Spoil> {};
INSTANTIATE_TEST_SUITE_P(
    All, Unsound,
    ::testing::Values<Spoil>(
        [](Package& p) { p.samples.positions[5] = Vec3f(1e6F, 0, 0); },
        [](Package& p) { p.samples.positions[5].x() = NAN; },
        [](Package& p) { p.samples.normals[5] *= 2.0F; },
        [](Package& p) { p.samples.tangents[5] = p.samples.normals[5]; },
        [](Package& p) { p.samples.areas[5] = NAN; }, [](Package& p) { p.samples.radii[5] = 0.0F; },
        [](Package& p) { p.samples.radii[5] = 1e9F; },
        [](Package& p) { p.samples.triangles[5] = 14; },
        [](Package& p) { p.samples.areas.pop_back(); },
        [](Package& p) { p.samples.cluster_begin[1] = 5000; },
        [](Package& p) { p.samples.cluster_begin.back() -= 1; },
        [](Package& p) { p.visibility->bound = 0.0F; },
        [](Package& p) { p.visibility->bias = 1.0F; },
        [](Package& p) { p.visibility->directions = 67; },
        [](Package& p) { p.visibility->clusters.pop_back(); },
        [](Package& p) { p.visibility->clusters[1].basis.float32[3] = INFINITY; },
        [](Package& p) { p.visibility->clusters[1].mean = {}; },
        [](Package& p) { p.visibility->clusters[1].coefficients.rows -= 1; },
        [](Package& p) { p.visibility.reset(); }, [](Package& p) { p.spaces[1].dimension = 7; },
        [](Package& p) { p.spaces[1].name = "e"; }, [](Package& p) { p.spaces.pop_back(); },
        [](Package& p) { p.program.pop_back(); },
        [](Package& p) { p.program.push_back(ReconstructStep{"e"}); },
        [](Package& p) {
          p.program[1] = ApplyStep{"nobody", "e", "c"};
        },
        [](Package& p) {
          p.program[1] = ApplyStep{"project", "i", "c"};
        },
        [](Package& p) {
          p.program[2] = ApplyStep{"transfer", "e", "i"};
        },
        [](Package& p) {
          p.program[2] = ApplyStep{"transfer", "c", "e"};
        },
        [](Package& p) {
          p.program[5] = AddStep{"e", "c", "sum"};
        },
        [](Package& p) { p.program.back() = ReconstructStep{"c"}; },
        [](Package& p) { p.program.insert(p.program.begin(), DirectLightStep{"sum"}); },
        [](Package& p) { std::get<ClusterProjection>(p.operators["project"]).blocks[0].cols -= 1; },
        [](Package& p) { std::get<ClusterProjection>(p.operators["project"]).blocks.pop_back(); },
        [](Package& p) { std::get<ClusterTransfer>(p.operators["transfer"]).channels = 2; },
        [](Package& p) {
          std::get<ClusterTransfer>(p.operators["transfer"]).receivers[2].senders[5] = 6;
        },
        [](Package& p) {
          std::get<ClusterTransfer>(p.operators["transfer"]).receivers[2].senders[5] = 4;
        },
        [](Package& p) {
          std::get<ClusterTransfer>(p.operators["transfer"]).receivers[2].senders.pop_back();
        },
        [](Package& p) {
          auto& left = std::get<ClusterTransfer>(p.operators["transfer"]).receivers[2].left;
          left = quantise(MatrixF::Ones(144, 2), 32).matrix;
        }));

MatrixF& walls_of(Package& p, Eigen::Index rows) {
  p.visibility->clusters[1] = {};
  MatrixF& walls = p.visibility->clusters[1].walls;
  walls = MatrixF::Zero(rows, 4);
  walls.col(2).setOnes();
  return walls;
}
INSTANTIATE_TEST_SUITE_P(Walls, Unsound,
                         ::testing::Values<Spoil>(
                             [](Package& p) {
                               p.visibility->clusters[1].walls = MatrixF::Identity(1, 4);
                             },
                             [](Package& p) { walls_of(p, 2)(1, 2) = 0.5F; },
                             [](Package& p) { walls_of(p, 2)(1, 0) = NAN; },
                             [](Package& p) { walls_of(p, 2)(1, 3) = NAN; },
                             [](Package& p) { walls_of(p, 2)(1, 3) = -0.1F; },
                             [](Package& p) { walls_of(p, 2)(1, 3) = INFINITY; },
                             [](Package& p) { walls_of(p, kMostWalls + 1); },
                             [](Package& p) { walls_of(p, 2).resize(1, 3); }));

using Near = NearTransfer;
Near& near_of(Package& p) { return std::get<Near>(p.operators["near"]); }
INSTANTIATE_TEST_SUITE_P(NearTransfer, Unsound,
                         ::testing::Values<Spoil>([](Package& p) { near_of(p).channels = 2; },
                                                  [](Package& p) { near_of(p).begin.pop_back(); },
                                                  [](Package& p) { near_of(p).begin[4] = 1; },
                                                  [](Package& p) { near_of(p).begin.back() -= 1; },
                                                  [](Package& p) { near_of(p).senders[9] = 864; },
                                                  [](Package& p) { near_of(p).shares.pop_back(); },
                                                  [](Package& p) { near_of(p).albedo.pop_back(); },
                                                  [](Package& p) {
                                                    p.program[3] = ApplyStep{"near", "c", "n"};
                                                  },
                                                  [](Package& p) { p.spaces[4].dimension = 6; }));

TEST_P(Unsound, IsRefused) {
  Package package = synthetic_room();
  test::add_near(package);
  validate(package, "room");
  GetParam()(package);
  EXPECT_THROW(validate(package, "room"), UserError);
}

}  // namespace
}  // namespace prt
