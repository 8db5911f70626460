// Whole bakes, through the real coordinator, worker and store, on a disk that fails in every way we
// can think of: afterwards nothing wrong may lie under a final name, and once the cause is gone the
// same command must end in the very bytes of a bake that nothing disturbed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "apps/bake/bake_session.h"
#include "base/log.h"
#include "base/random.h"
#include "support/program.h"
#include "support/simulated_disk.h"
#include "support/toy_method.h"

namespace prt::test {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;
using Files = std::map<std::string, std::vector<std::byte>>;

const fs::path kRoot = "/disk";
const fs::path kBake = kRoot / "out" / "bake";
const std::string kMarker = (kBake / "complete.json").string();
const std::string kPackage = (kBake / "bake.prt.glb").string();

struct Ended {
  ExitCode code = ExitCode::kDone;
  std::string said;  ///< all of stderr
};

bool is_artifact(const std::string& name) {
  return name.ends_with(".h5") && name.find("/artifacts/") != std::string::npos;
}

/// What a bake is for: its artifacts, package, index and marker. The log and the report hold times.
Files results(const Files& files) {
  Files kept;
  for (const auto& [name, bytes] : files) {
    if (is_artifact(name) || name == kPackage || name == kMarker || name.ends_with("/bake.h5")) {
      kept.emplace(name, bytes);
    }
  }
  return kept;
}

std::string names(const Files& files) {
  std::string text;
  for (const auto& [name, bytes] : files) text += name + " " + std::to_string(bytes.size()) + "\n";
  return text;
}

class StorageFaults : public testing::Test {
 protected:
  StorageFaults() {
    std::ofstream(folder_.path / "toy.scene") << "a triangle";
    std::ofstream(folder_.path / "toy.yaml") << "scene: toy.scene\noutput: " << kBake.string()
                                             << "\nmethods: [toy]\ntoy: {leaves: 6, values: 50}\n";
    log::set_up(-1);
  }

  static std::shared_ptr<SimulatedDisk> new_disk() {
    auto disk = std::make_shared<SimulatedDisk>(kRoot);
    disk->uncounted = "progress.json";  // once a second; nothing depends on it
    return disk;
  }

  Ended bake(const std::shared_ptr<SimulatedDisk>& disk, const ConfigOverrides& overrides = {}) {
    BakeProgram program = toy_program();
    program.file_system = disk;
    BakeCommand command;
    command.config = folder_.path / "toy.yaml";
    command.overrides = overrides;
    command.threads = 1;
    command.verbosity = -1;
    const auto ranks = make_single_rank();
    Ended ended;
    testing::internal::CaptureStderr();
    try {
      ended.code = prt::bake(command, program, *ranks);
    } catch (const UserError& error) {
      std::fprintf(stderr, "%s", error.what());
      ended.code = ExitCode::kBadInput;
    }
    setitimer(ITIMER_REAL, &kNoTimer, nullptr);  // the limit of the failed program's farewell
    ended.said = testing::internal::GetCapturedStderr();
    return ended;
  }

  /// An undisturbed bake's results, and how many calls it makes.
  const Files& reference() {
    if (reference_.empty()) {
      const auto disk = new_disk();
      const Ended ended = bake(disk);
      EXPECT_EQ(ended.code, ExitCode::kDone) << ended.said;
      reference_ = results(disk->files());
      calls_ = disk->calls();
    }
    return reference_;
  }

  std::size_t calls() {
    reference();
    return calls_;
  }

  /// Whatever has happened: what bears a final name is right.
  void expect_nothing_wrong(const SimulatedDisk& disk) {
    const Files found = results(disk.files());
    for (const auto& [name, bytes] : found) {
      if (name.ends_with("/bake.h5") && !found.contains(kMarker)) continue;  // of unfinished work
      ASSERT_TRUE(reference().contains(name)) << name;
      ASSERT_TRUE(reference().at(name) == bytes) << name << ": wrong bytes";
    }
    ASSERT_TRUE(!found.contains(kMarker) || found.contains(kPackage)) << names(found);
  }

  /// A bake that may fail: what it says of its end is true. True if it is done.
  bool expect_done_or_told(const std::shared_ptr<SimulatedDisk>& disk) {
    const Ended ended = bake(disk);
    expect_nothing_wrong(*disk);
    if (ended.code == ExitCode::kDone) {
      EXPECT_TRUE(results(disk->files()) == reference()) << names(results(disk->files()));
      return true;
    }
    EXPECT_EQ(ended.code, ExitCode::kBadInput) << ended.said;
    EXPECT_THAT(ended.said, HasSubstr(": cannot "));
    return false;
  }

  /// The cause is gone: the same command gets to the same bytes.
  void expect_completes(const std::shared_ptr<SimulatedDisk>& disk) {
    disk->before = nullptr;
    const Ended ended = bake(disk);
    ASSERT_EQ(ended.code, ExitCode::kDone) << ended.said;
    const Files found = results(disk->files());
    ASSERT_TRUE(found == reference()) << names(found) << "where these belong:\n"
                                      << names(reference());
    for (const auto& [name, bytes] : disk->files()) {
      ASSERT_FALSE(name.starts_with(kBake.string() + "/artifacts/") && !is_artifact(name))
          << name << " was left behind";
    }
  }

  static constexpr itimerval kNoTimer{};

 private:
  TemporaryFolder folder_;
  Files reference_;
  std::size_t calls_ = 0;
};

/// Reasons a call may fail for.
constexpr int kErrors[] = {EIO, ENOSPC, EROFS, EACCES, ESTALE};

TEST_F(StorageFaults, AnUndisturbedBakeIsCompleteAndFoundAgain) {
  ASSERT_EQ(results(reference()).size(), 13U);  // 10 tasks, index, package and marker
  const auto disk = new_disk();
  ASSERT_EQ(bake(disk).code, ExitCode::kDone);
  expect_completes(disk);
}

TEST_F(StorageFaults, EveryCallMayFailOnce) {
  int told = 0;
  for (std::size_t n = 0; n < 2 * calls(); ++n) {
    SCOPED_TRACE("call " + std::to_string(n / 2) + (n % 2 == 0 ? "" : ", which happened"));
    const auto disk = new_disk();
    disk->failed_calls_happen = n % 2 == 1;
    disk->before = [&](const SimulatedDisk::Call& call) {
      if (call.number != n / 2) return;
      throw FileError(call.path, changes_disk(call.kind) ? "write" : "read",
                      kErrors[n / 2 % std::size(kErrors)]);
    };
    told += expect_done_or_told(disk) ? 0 : 1;
    expect_completes(disk);
    if (HasFailure()) return;
  }
  EXPECT_GT(told, static_cast<int>(calls()));  // of two for each call: most failures end a bake
}

TEST_F(StorageFaults, FromAnyCallOnNothingCanBeWritten) {
  for (std::size_t n = 0; n < calls(); ++n) {
    SCOPED_TRACE("call " + std::to_string(n));
    const auto disk = new_disk();
    const int error = n % 2 == 0 ? EROFS : EIO;
    disk->before = [&](const SimulatedDisk::Call& call) {
      if (call.number >= n && changes_disk(call.kind)) throw FileError(call.path, "write", error);
    };
    expect_done_or_told(disk);
    expect_completes(disk);
    if (HasFailure()) return;
  }
}

/// The power goes at call `number`.
std::function<void(const SimulatedDisk::Call&)> outage_at(SimulatedDisk& disk, std::size_t number) {
  return [&disk, number](const SimulatedDisk::Call& call) {
    if (call.number != number) return;
    disk.lose_power();
    throw FileError(call.path, "reach", EIO);
  };
}

TEST_F(StorageFaults, ThePowerMayGoAtAnyCallAndAgainDuringTheResume) {
  constexpr std::uint64_t kChances = 3;
  std::size_t with_results = 0;
  for (std::size_t n = 0; n < kChances * calls(); ++n) {
    SCOPED_TRACE("case " + std::to_string(n));
    Random random(stream_key(n, "outages"), 0);
    auto disk = new_disk();
    std::size_t last = n / kChances;
    for (int outage = 0; outage < 2; ++outage) {
      disk->before = outage_at(*disk, last);
      bake(disk);
      disk = disk->after_outage(random.bits());
      expect_nothing_wrong(*disk);
      last = random.below(static_cast<std::uint32_t>(calls()));
    }
    with_results += results(disk->files()).empty() ? 0 : 1;
    expect_completes(disk);
    if (HasFailure()) return;
  }
  EXPECT_GT(with_results, kChances * calls() / 2);  // the others had nothing yet
}

TEST_F(StorageFaults, WhatIsDoneSurvivesALossOfPower) {
  const auto disk = new_disk();
  ASSERT_EQ(bake(disk).code, ExitCode::kDone);
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    ASSERT_TRUE(results(disk->after_outage(seed)->files()) == reference()) << "seed " << seed;
  }
}

std::string marker_of(const Files& files) {
  const auto& marker = files.at(kMarker);
  return {reinterpret_cast<const char*>(marker.data()), marker.size()};
}

TEST_F(StorageFaults, TheMarkerOfAnOlderBakeNeverStandsBesideAnotherPackage) {
  constexpr std::size_t kChances = 16;
  ConfigOverrides other;
  other.settings = {"toy.values=60"};
  const auto undisturbed = new_disk();
  ASSERT_EQ(bake(undisturbed, other).code, ExitCode::kDone);
  const std::string new_marker = marker_of(undisturbed->files());
  ASSERT_NE(new_marker, marker_of(reference()));
  int old_ones = 0;
  int new_ones = 0;
  const std::size_t most = 2 * calls();  // it looks at the old results, too
  for (std::size_t n = 0; n < most; ++n) {
    const auto disk = new_disk();
    ASSERT_EQ(bake(disk).code, ExitCode::kDone);
    disk->before = outage_at(*disk, disk->calls() + n);
    bake(disk, other);
    for (std::size_t seed = 0; seed < kChances; ++seed) {
      const Files files = disk->after_outage(n * kChances + seed)->files();
      if (!files.contains(kMarker)) continue;
      ASSERT_TRUE(files.contains(kPackage));
      const std::string marker = marker_of(files);
      ++(marker == new_marker ? new_ones : old_ones);
      ASSERT_THAT(marker, HasSubstr(hash_bytes(files.at(kPackage)).hex()))
          << "call " << n << ", seed " << seed;
    }
  }
  EXPECT_GT(old_ones, 0);
  EXPECT_GT(new_ones, 0);
}

TEST_F(StorageFaults, AFullDiskIsToldAndSpaceIsAllItTakes) {
  std::uint64_t whole = 0;
  for (const auto& [name, bytes] : reference()) whole += bytes.size();
  constexpr std::uint64_t kSteps = 40;
  for (std::uint64_t step = 0; step < kSteps; ++step) {
    const auto disk = new_disk();
    disk->capacity = whole * step / kSteps;
    SCOPED_TRACE(std::to_string(disk->capacity) + " bytes");
    const Ended ended = bake(disk);
    ASSERT_EQ(ended.code, ExitCode::kBadInput) << ended.said;
    ASSERT_THAT(ended.said, HasSubstr("free some space"));
    expect_nothing_wrong(*disk);
    disk->capacity = std::numeric_limits<std::uint64_t>::max();
    expect_completes(disk);
    if (HasFatalFailure()) return;
  }
}

TEST_F(StorageFaults, ADiskThatCannotBeWrittenIsToldAtOnce) {
  const auto disk = new_disk();
  disk->before = [](const SimulatedDisk::Call& call) {
    if (changes_disk(call.kind)) throw FileError(call.path, "write", EROFS);
  };
  const Ended ended = bake(disk);
  EXPECT_EQ(ended.code, ExitCode::kBadInput);
  EXPECT_THAT(ended.said, HasSubstr("make it accessible or choose another folder"));
  EXPECT_TRUE(disk->files().empty()) << names(disk->files());
}

TEST_F(StorageFaults, AFileOfAnotherClientMayShowLate) {
  // As an NFS client that has remembered that a name is not there: the file is neither seen nor
  // read, although the rank that made it has said that it is there.
  constexpr int kLate = 2;
  const auto disk = new_disk();
  std::map<std::string, int> denied;
  disk->before = [&](const SimulatedDisk::Call& call) {
    if (changes_disk(call.kind) || !is_artifact(call.path.string())) return;
    if (++denied[call.path.string()] <= kLate) throw FileError(call.path, "read", ENOENT);
  };
  const Ended ended = bake(disk);
  EXPECT_EQ(ended.code, ExitCode::kDone) << ended.said;
  EXPECT_TRUE(results(disk->files()) == reference());
  EXPECT_GT(denied.size(), 5U);
}

}  // namespace
}  // namespace prt::test
