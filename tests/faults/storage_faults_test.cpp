// Whole bakes, through the real coordinator, worker and store, on a disk that fails in every way we
// can think of: afterwards nothing wrong may lie under a final name, and once the cause is gone the
// same command must end in the very bytes of a bake that nothing disturbed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "apps/bake/bake_session.h"
#include "base/log.h"
#include "base/random.h"
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
    fs::create_directories(folder_);
    std::ofstream(folder_ / "toy.scene") << "a triangle";
    std::ofstream(folder_ / "toy.yaml") << "scene: toy.scene\noutput: " << kBake.string()
                                        << "\nmethods: [toy]\ntoy: {leaves: 6, values: 50}\n";
    log::set_up(-1);
  }
  ~StorageFaults() override { fs::remove_all(folder_); }
  StorageFaults(const StorageFaults&) = delete;
  StorageFaults& operator=(const StorageFaults&) = delete;

  Ended bake(const std::shared_ptr<SimulatedDisk>& disk, const ConfigOverrides& overrides = {}) {
    BakeProgram program = toy_program();
    program.file_system = disk;
    BakeCommand command;
    command.config = folder_ / "toy.yaml";
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
      const auto disk = std::make_shared<SimulatedDisk>(kRoot);
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
  fs::path folder_ =
      fs::temp_directory_path() / ("prt.StorageFaults." + std::to_string(getpid()) + "." +
                                   testing::UnitTest::GetInstance()->current_test_info()->name());
  Files reference_;
  std::size_t calls_ = 0;
};

/// Reasons a call may fail for.
constexpr int kErrors[] = {EIO, ENOSPC, EROFS, EACCES, ESTALE};

TEST_F(StorageFaults, AnUndisturbedBakeIsCompleteAndFoundAgain) {
  ASSERT_EQ(results(reference()).size(), 13U);  // 10 tasks, index, package and marker
  const auto disk = std::make_shared<SimulatedDisk>(kRoot);
  ASSERT_EQ(bake(disk).code, ExitCode::kDone);
  expect_completes(disk);
}

TEST_F(StorageFaults, EveryCallMayFailOnce) {
  int told = 0;
  for (std::size_t n = 0; n < calls(); ++n) {
    SCOPED_TRACE("call " + std::to_string(n));
    const auto disk = std::make_shared<SimulatedDisk>(kRoot);
    std::string failed;
    disk->before = [&](const SimulatedDisk::Call& call) {
      if (call.number != n) return;
      failed = call.path.string();
      throw FileError(call.path, changes_disk(call.kind) ? "write" : "read",
                      kErrors[n % std::size(kErrors)]);
    };
    const Ended ended = bake(disk);
    if (ended.code != ExitCode::kDone) {
      ++told;
      ASSERT_EQ(ended.code, ExitCode::kBadInput) << ended.said;
      ASSERT_THAT(ended.said, HasSubstr(kRoot.string())) << failed;
    }
    expect_nothing_wrong(*disk);
    expect_completes(disk);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(told, 20);  // most failures of a write end the bake
}

TEST_F(StorageFaults, FromAnyCallOnNothingCanBeWritten) {
  for (std::size_t n = 0; n < calls(); ++n) {
    SCOPED_TRACE("call " + std::to_string(n));
    const auto disk = std::make_shared<SimulatedDisk>(kRoot);
    const int error = n % 2 == 0 ? EROFS : EIO;
    disk->before = [&](const SimulatedDisk::Call& call) {
      if (call.number >= n && changes_disk(call.kind)) throw FileError(call.path, "write", error);
    };
    const Ended ended = bake(disk);
    ASSERT_TRUE(ended.code == ExitCode::kBadInput || disk->files().contains(kMarker)) << ended.said;
    expect_nothing_wrong(*disk);
    expect_completes(disk);
    if (HasFatalFailure()) return;
  }
}

TEST_F(StorageFaults, ThePowerMayGoAtAnyCallAndAgainDuringTheResume) {
  constexpr std::uint64_t kChances = 3;
  for (std::size_t n = 0; n < calls(); ++n) {
    for (std::uint64_t seed = 0; seed < kChances; ++seed) {
      SCOPED_TRACE("call " + std::to_string(n) + ", seed " + std::to_string(seed));
      const auto disk = std::make_shared<SimulatedDisk>(kRoot);
      std::size_t last = n;
      disk->before = [&](const SimulatedDisk::Call& call) {
        if (call.number != last) return;
        disk->lose_power();
        throw FileError(call.path, "reach", EIO);
      };
      for (int outage = 0; outage < 2; ++outage) {
        bake(disk);
        disk->restart(seed);
        expect_nothing_wrong(*disk);
        last = disk->calls() + Random(stream_key(seed, "outage"), n).below(calls());
      }
      expect_completes(disk);
      if (HasFatalFailure()) return;
    }
  }
}

TEST_F(StorageFaults, TheMarkerOfAnOlderBakeNeverStandsBesideAnotherPackage) {
  ConfigOverrides other;
  other.settings = {"toy.values=60"};
  for (std::size_t n = 0; n < 2 * calls(); ++n) {
    SCOPED_TRACE("call " + std::to_string(n));
    const auto disk = std::make_shared<SimulatedDisk>(kRoot);
    ASSERT_EQ(bake(disk).code, ExitCode::kDone);
    const std::size_t last = disk->calls() + n;
    disk->before = [&](const SimulatedDisk::Call& call) {
      if (call.number != last) return;
      disk->lose_power();
      throw FileError(call.path, "reach", EIO);
    };
    bake(disk, other);
    disk->restart(n);
    const Files files = disk->files();
    if (files.contains(kMarker)) {
      const auto& marker = files.at(kMarker);
      const std::string text(reinterpret_cast<const char*>(marker.data()), marker.size());
      ASSERT_THAT(text, HasSubstr(hash_bytes(files.at(kPackage)).hex()));
    }
  }
}

TEST_F(StorageFaults, AFullDiskIsToldAndSpaceIsAllItTakes) {
  std::uint64_t whole = 0;
  for (const auto& [name, bytes] : reference()) whole += bytes.size();
  constexpr std::uint64_t kSteps = 40;
  int full = 0;
  for (std::uint64_t step = 0; step < kSteps; ++step) {
    const auto disk = std::make_shared<SimulatedDisk>(kRoot);
    disk->capacity = whole * step / kSteps;
    SCOPED_TRACE(std::to_string(disk->capacity) + " bytes");
    const Ended ended = bake(disk);
    if (ended.code != ExitCode::kDone) {
      ++full;
      ASSERT_EQ(ended.code, ExitCode::kBadInput) << ended.said;
      ASSERT_THAT(ended.said, HasSubstr("free some space"));
    }
    expect_nothing_wrong(*disk);
    disk->capacity = std::numeric_limits<std::uint64_t>::max();
    expect_completes(disk);
    if (HasFatalFailure()) return;
  }
  EXPECT_EQ(full, kSteps);
}

TEST_F(StorageFaults, ADiskThatCannotBeWrittenIsToldAtOnce) {
  const auto disk = std::make_shared<SimulatedDisk>(kRoot);
  disk->before = [](const SimulatedDisk::Call& call) {
    if (changes_disk(call.kind)) throw FileError(call.path, "write", EROFS);
  };
  const Ended ended = bake(disk);
  EXPECT_EQ(ended.code, ExitCode::kBadInput);
  EXPECT_THAT(ended.said, HasSubstr("make it accessible or choose another folder"));
  EXPECT_TRUE(disk->files().empty()) << names(disk->files());
}

TEST_F(StorageFaults, ASlowDiskTakesLongerAndNoMore) {
  const auto disk = std::make_shared<SimulatedDisk>(kRoot);
  disk->before = [](const SimulatedDisk::Call& call) {
    using namespace std::chrono_literals;
    if (call.kind == DiskCall::kSync || call.kind == DiskCall::kSyncDir) {
      std::this_thread::sleep_for(30ms);
    }
  };
  const Ended ended = bake(disk);
  EXPECT_EQ(ended.code, ExitCode::kDone) << ended.said;
  EXPECT_TRUE(results(disk->files()) == reference());
}

TEST_F(StorageFaults, AFileOfAnotherClientMayShowLate) {
  // As an NFS client that has remembered that a name is not there: the file cannot be read, and by
  // its size is not there, although the rank that made it has said that it is.
  constexpr int kLate = 2;
  const auto disk = std::make_shared<SimulatedDisk>(kRoot);
  std::map<std::string, int> denied;
  disk->before = [&](const SimulatedDisk::Call& call) {
    if (call.kind != DiskCall::kRead || !is_artifact(call.path.string())) return;
    if (++denied[call.path.string()] <= kLate) throw FileError(call.path, "read", ENOENT);
  };
  const Ended ended = bake(disk);
  EXPECT_EQ(ended.code, ExitCode::kDone) << ended.said;
  EXPECT_TRUE(results(disk->files()) == reference());
  EXPECT_GT(denied.size(), 5U);
}

}  // namespace
}  // namespace prt::test
