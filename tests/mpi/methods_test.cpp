// Methods through the real service: what one of them made another finds.
#include <gtest/gtest.h>

#include "support/program.h"

namespace prt {
namespace {

class Methods : public testing::Test {
 protected:
  [[nodiscard]] std::unique_ptr<test::Program> bake(const std::string& scene,
                                                    const std::string& methods) const {
    const std::string source = PRT_SOURCE_DIR;
    std::vector<std::string> command = {std::string(PRT_BINARY_DIR) + "/bin/prt_bake",
                                        source + "/configs/default.yaml"};
    for (const std::string& setting :
         {"scene=" + source + "/configs/scenes/" + scene, "methods=" + methods,
          std::string("samples.count=600"), std::string("samples.cluster_size=150"),
          std::string("rays.directions=256"), std::string("lb.example_lights=40"),
          std::string("evaluate.lights=1"), std::string("evaluate.points=50"),
          std::string("evaluate.spp=4")}) {
      command.insert(command.end(), {"--set", setting});
    }
    command.insert(command.end(), {"--out", folder().string()});
    auto program = test::start_bake(command, {}, PRT_MPIRUN, folder_.path / "log.txt");
    return program;
  }
  [[nodiscard]] test::fs::path folder() const { return folder_.path / "bake"; }
  /// Name and time of each of a stage's artifacts.
  [[nodiscard]] std::map<std::string, test::fs::file_time_type> artifacts(
      const std::string& stage) const {
    std::map<std::string, test::fs::file_time_type> all;
    for (const auto& file : test::fs::directory_iterator(folder() / "artifacts" / stage)) {
      all[file.path().filename()] = file.last_write_time();
    }
    return all;
  }
  test::TemporaryFolder folder_;
};

TEST_F(Methods, AnotherOneFindsRaysAndSamples) {
  const auto first = bake("cornell.glb", "[lb]");
  ASSERT_EQ(first->wait(), 0) << first->output();
  const auto rays = artifacts("rays"), samples = artifacts("samples");
  ASSERT_FALSE(rays.empty());
  const auto both = bake("cornell.glb", "[lb, sh]");
  ASSERT_EQ(both->wait(), 0) << both->output();
  EXPECT_EQ(artifacts("rays"), rays);
  EXPECT_EQ(artifacts("samples"), samples);
  EXPECT_EQ(artifacts("sky_transfer").size(), rays.size());
  const auto alone = bake("cornell.glb", "sh");
  ASSERT_EQ(alone->wait(), 0) << alone->output();
  EXPECT_EQ(artifacts("rays"), rays);
  EXPECT_NE(alone->output().find(" found, "), std::string::npos) << alone->output();
}

TEST_F(Methods, TheSkyAloneOfAClosedRoomIsRefusedInOneLine) {
  const auto alone = bake("closed_box.glb", "sh");
  EXPECT_EQ(alone->wait(), 2);
  const std::string said = alone->output();
  EXPECT_NE(said.find("no environment layer: no cluster sees"), std::string::npos) << said;
  EXPECT_FALSE(test::fs::exists(folder() / "bake.prt.glb"));
  const auto both = bake("closed_box.glb", "[lb, sh]");
  EXPECT_EQ(both->wait(), 0) << both->output();
  EXPECT_TRUE(test::fs::exists(folder() / "bake.prt.glb"));
}

}  // namespace
}  // namespace prt
