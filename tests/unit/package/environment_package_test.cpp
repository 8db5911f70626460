// Packages with an environment: what a file keeps of them, and what is refused.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "base/error.h"
#include "package/read.h"
#include "package/write.h"
#include "unit/package/synthetic_package.h"

namespace prt {
namespace {

constexpr int kOrder = 3;

Package room() {
  Package package = test::synthetic_room({.samples_per_edge = 4, .bits = 8});
  test::add_environment(package, kOrder);
  return package;
}

TEST(EnvironmentPackage, KeepsStepsSpacesAndFactors) {
  const auto file = std::filesystem::temp_directory_path() /
                    ("prt_environment_" + std::to_string(getpid()) + ".prt.glb");
  const Package before = room();
  write_package(before, file);
  const Package after = read_package(file);
  std::filesystem::remove(file);
  EXPECT_EQ(environment_order(after), kOrder);
  EXPECT_TRUE(has_direct_light(after));
  ASSERT_EQ(after.program.size(), before.program.size());
  const auto* step = std::get_if<EnvironmentLightStep>(&after.program[after.program.size() - 5]);
  ASSERT_NE(step, nullptr);
  EXPECT_EQ(step->op, "sky");
  EXPECT_EQ(step->coefficients, "sky light");
  EXPECT_EQ(step->output, "sky");
  const auto& sky = std::get<ClusterTransfer>(after.operators.at("sky"));
  const auto& original = std::get<ClusterTransfer>(before.operators.at("sky"));
  EXPECT_EQ(sky.channels, 1U);
  for (std::size_t c = 0; c < sky.receivers.size(); ++c) {
    EXPECT_EQ(sky.receivers[c].senders, std::vector<std::uint32_t>{0});
    EXPECT_EQ(sky.receivers[c].left.float32, original.receivers[c].left.float32);
  }
}

TEST(EnvironmentPackage, AloneNeedsANewReader) {
  const auto version = [](const Package& package) {
    const std::vector<std::byte> bytes = encode_package(package);
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    for (const char* v : {"\"version\":1,", "\"version\":2,", "\"version\":3,"}) {
      if (text.find(v) != text.npos) return v[10];
    }
    return '?';
  };
  EXPECT_EQ(version(test::synthetic_room()), '1');
  EXPECT_EQ(version(room()), '3');
}

TEST(EnvironmentPackage, IsAskedForByName) {
  const Package with = room();
  EXPECT_NO_THROW(require_environment(with, "room"));
  EXPECT_NO_THROW(require_direct_light(with, "room"));
  EXPECT_THROW(require_environment(test::synthetic_room(), "room"), UserError);
  Package alone = room();
  alone.program = {EnvironmentLightStep{"sky", "sky light", "sky"}, ReconstructStep{"sky"}};
  validate(alone, "sky alone");
  EXPECT_THROW(require_direct_light(alone, "room"), UserError);
}

using Spoil = void (*)(Package&);
class UnsoundEnvironment : public testing::TestWithParam<Spoil> {};

Space& coefficients_of(Package& p) {
  return *std::ranges::find(p.spaces, std::string("sky light"), &Space::name);
}
EnvironmentLightStep& step_of(Package& p) {
  return std::get<EnvironmentLightStep>(p.program[p.program.size() - 5]);
}

/// So many coefficients, and factors that fit them.
void resize_environment(Package& p, std::uint32_t count) {
  coefficients_of(p).dimension = count;
  for (const char* name : {"sky", "bounced"}) {
    auto& transfer = std::get<ClusterTransfer>(p.operators[name]);
    for (ReceiverTransfer& receiver : transfer.receivers) {
      receiver.right =
          quantise(MatrixF::Ones(receiver.right.rows, transfer.channels * count), 8).matrix;
    }
  }
}

TEST(EnvironmentPackage, MayHaveAnyOrderUpToEight) {
  for (const std::uint32_t order : {1U, 2U, 8U}) {
    Package package = room();
    resize_environment(package, order * order);
    EXPECT_NO_THROW(validate(package, "room")) << order;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Spoiled, UnsoundEnvironment,
    testing::Values<Spoil>(
        [](Package& p) { coefficients_of(p).dimension = 8; },  // no square
        [](Package& p) { coefficients_of(p).dimension = 0; },
        [](Package& p) { coefficients_of(p).dimension = 4; },   // another order
        [](Package& p) { coefficients_of(p).dimension = 81; },  // order 9
        [](Package& p) { coefficients_of(p).dimension = 4294836225U; },
        [](Package& p) { coefficients_of(p).kind = Space::Kind::kClusterCoefficients; },
        [](Package& p) { step_of(p).coefficients = "sky"; },
        [](Package& p) { step_of(p).coefficients = "nobody"; },
        [](Package& p) { step_of(p).output = "e"; }, [](Package& p) { step_of(p).op = "project"; },
        [](Package& p) { step_of(p).op = "transfer"; },  // of the room's clusters
        [](Package& p) { step_of(p).op = "nobody"; },
        [](Package& p) {
          p.program.insert(p.program.end() - 1, EnvironmentLightStep{"sky", "sky light", "sky"});
        },
        [](Package& p) { resize_environment(p, 8); }, [](Package& p) { resize_environment(p, 81); },
        [](Package& p) {  // another, with spaces of its own
          p.spaces.push_back({"more light", Space::Kind::kEnvironmentCoefficients, 9});
          p.spaces.push_back({"more", Space::Kind::kSampleIrradiance, p.spaces[0].dimension});
          p.program.insert(p.program.end() - 1, EnvironmentLightStep{"sky", "more light", "more"});
        },
        [](Package& p) { p.program.back() = ReconstructStep{"sky light"}; },
        [](Package& p) {
          std::get<ClusterTransfer>(p.operators["sky"]).receivers[1].senders = {1};
        },
        [](Package& p) { std::get<ClusterTransfer>(p.operators["sky"]).receivers[1].senders = {}; },
        [](Package& p) { p.program = {ReconstructStep{"sky"}}; }));

TEST_P(UnsoundEnvironment, IsRefused) {
  Package package = room();
  validate(package, "room");
  GetParam()(package);
  EXPECT_THROW(validate(package, "room"), UserError);
}

}  // namespace
}  // namespace prt
