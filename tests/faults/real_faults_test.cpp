// Real files spoiled in real ways, and a real file system that is full: the bake says what is
// wrong, uses nothing of it, and ends in the bytes of a bake that nothing disturbed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/program.h"

namespace prt {
namespace {

using test::fs::path;
using testing::HasSubstr;
using Results = std::map<std::string, std::string>;

path binary(const std::string& name) { return path(PRT_BINARY_DIR) / "bin" / name; }

/// Small, but with tasks of every kind.
const std::vector<std::string> kTiny = {
    "samples.count=800", "samples.cluster_size=200", "rays.directions=256", "lb.example_lights=50",
    "evaluate.lights=2", "evaluate.points=50",       "evaluate.spp=4"};

class RealFaults : public testing::Test {
 protected:
  int bake(const path& out) {
    test::BakeRun run{0, 2};
    for (const std::string& option : kTiny) run.more.insert(run.more.end(), {"--set", option});
    const std::string source = PRT_SOURCE_DIR;
    run.more.insert(run.more.end(), {"--set", "scene=" + source + "/configs/scenes/cornell.glb"});
    run.more.insert(run.more.end(), {"--out", out.string()});
    const auto program =
        test::start_bake({binary("prt_bake").string(), source + "/configs/default.yaml"}, run, "",
                         folder_.path / "log.txt");
    const int code = program->wait();
    said_ = program->output();
    return code;
  }

  test::TemporaryFolder folder_;
  std::string said_;
};

/// One artifact of each kind, in order of their names.
std::map<std::string, path> one_of_each_kind(const path& bake) {
  std::map<std::string, path> found;
  for (const auto& stage : test::fs::directory_iterator(bake / "artifacts")) {
    for (const auto& file : test::fs::directory_iterator(stage)) {
      path& first = found[stage.path().filename().string()];
      if (first.empty() || file.path() < first) first = file.path();
    }
  }
  return found;
}

void flip_a_bit(const path& file) {
  std::string bytes = test::read_text(file);
  bytes.at(bytes.size() / 2) ^= 0x10;
  std::ofstream(file, std::ios::binary) << bytes;
}

/// False if nothing is left of the file.
bool spoil(const path& file, std::size_t how) {
  switch (how % 3) {
    case 0:
      flip_a_bit(file);
      return true;
    case 1:
      test::fs::resize_file(file, test::fs::file_size(file) / 2);
      return true;
    default:
      test::fs::remove(file);
      return false;
  }
}

TEST_F(RealFaults, DamageInAnyKindOfArtifactIsFoundAndMended) {
  const path out = folder_.path / "room";
  ASSERT_EQ(bake(out), 0) << said_;
  const Results expected = test::bake_results(out);
  for (std::size_t round = 0; round < 3; ++round) {
    const auto victims = one_of_each_kind(out);
    ASSERT_GE(victims.size(), 18U);
    std::size_t how = round;
    std::size_t spoiled = 0;  // and still there
    for (const auto& [kind, file] : victims) spoiled += spoil(file, how++) ? 1 : 0;
    flip_a_bit(out / "manifest.log");
    std::ofstream(victims.begin()->second.string() + ".99.tmp") << "left over";

    ASSERT_EQ(bake(out), 0) << said_;
    EXPECT_TRUE(test::bake_results(out) == expected) << "round " << round;
    EXPECT_THAT(said_, HasSubstr("; " + std::to_string(victims.size()) + " tasks made"));
    EXPECT_THAT(said_, HasSubstr("manifest.log: 1 torn or damaged line(s) skipped"));
    std::size_t told = 0;
    for (std::size_t at = said_.find("it will be made again"); at != std::string::npos;
         at = said_.find("it will be made again", at + 1)) {
      ++told;
    }
    EXPECT_EQ(told, spoiled) << said_;
  }
}

TEST_F(RealFaults, AFullFileSystemIsToldAndSpaceIsAllItTakes) {
  ASSERT_EQ(bake(folder_.path / "room"), 0) << said_;
  const Results expected = test::bake_results(folder_.path / "room");
  std::uintmax_t bytes = 0;
  for (const auto& [name, content] : expected) bytes += content.size();
  // A file system of half that size, in a mount namespace of our own; then a large one.
  const std::string disk = "'" + (folder_.path / "disk").string() + "'";
  test::fs::create_directory(folder_.path / "disk");
  const std::string source = PRT_SOURCE_DIR;
  std::string bake = "'" + binary("prt_bake").string() + "' '" + source +
                     "/configs/default.yaml' --threads 2 --out " + disk +
                     "/room --set 'scene=" + source + "/configs/scenes/cornell.glb'";
  for (const std::string& option : kTiny) bake += " --set " + option;
  std::ofstream(folder_.path / "script")
      << "set -e\n"
      << "mount -t tmpfs -o size=" << bytes / 2 << " tmpfs " << disk << "\n"
      << "echo mounted\n"
      << "status=0; " << bake << " || status=$?\n"
      << "echo \"first: $status\"\n"
      << "mount -o remount,size=1g " << disk << "\n"
      << bake << "\n"
      << "cp -r " << disk << "/room '" << (folder_.path / "copy").string() << "'\n";
  std::vector<std::string> command = {"unshare", "--mount"};
  if (geteuid() != 0) command.insert(command.end(), {"--user", "--map-root-user"});
  command.insert(command.end(), {"bash", (folder_.path / "script").string()});
  test::Program program(command, folder_.path / "full.txt");
  const int code = program.wait();
  if (program.output().find("mounted\n") == std::string::npos) {
    GTEST_SKIP() << "no file systems can be mounted here: " << program.output();
  }
  ASSERT_EQ(code, 0) << program.output();
  EXPECT_THAT(program.output(), HasSubstr("first: 2\n"));
  EXPECT_THAT(program.output(), HasSubstr("No space left on device; free some space"));
  EXPECT_TRUE(test::bake_results(folder_.path / "copy") == expected) << program.output();
}

}  // namespace
}  // namespace prt
