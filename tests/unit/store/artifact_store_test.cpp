#include "store/artifact_store.h"

#include <sys/resource.h>
#include <sys/wait.h>

#include <csignal>

#include "store_fixtures.h"

namespace prt {
namespace {

namespace fs = std::filesystem;

const Digest kKey = hash_text("key");

class ArtifactStoreTest : public testing::Test {
 protected:
  Digest write() { return store_.write("rays", kKey, varied_artifact(), {3, "eq. 8"}); }
  fs::path file() { return store_.path("rays", kKey); }

  TemporaryFolder folder_;
  PosixFileSystem disk_;
  ArtifactStore store_{disk_, folder_.path()};
};

TEST_F(ArtifactStoreTest, GivesBackWhatWasWritten) {
  const Digest content = write();
  EXPECT_EQ(file(), folder_.path() / "artifacts" / "rays" / (kKey.hex() + ".h5"));
  EXPECT_EQ(store_.check("rays", kKey), content);
  const LabelledArtifact head = store_.head("rays", kKey);
  EXPECT_EQ(head.label, (ArtifactLabel{"rays", kKey, 3, "eq. 8"}));
  EXPECT_EQ(head.artifact.attributes, varied_artifact().attributes);
  EXPECT_TRUE(head.artifact.datasets.empty());
  EXPECT_EQ(store_.bytes("rays", kKey), fs::file_size(file()));
  expect_equal(varied_artifact(), *store_.read("rays", kKey, content));
  EXPECT_TRUE(store_.remove("rays", kKey));
  EXPECT_FALSE(store_.remove("rays", kKey));
  EXPECT_EQ(store_.check("rays", kKey), std::nullopt);
  EXPECT_THROW((void)store_.read("rays", kKey, content), UnsoundData);
  EXPECT_EQ(store_.bytes("rays", kKey), 0U);
}

TEST_F(ArtifactStoreTest, LeavesNothingBesideTheArtifact) {
  write();
  write();
  EXPECT_EQ(disk_.list(file().parent_path()), std::vector<std::string>{file().filename()});
}

TEST_F(ArtifactStoreTest, RefusesOtherContent) {
  write();
  EXPECT_THROW((void)store_.read("rays", kKey, hash_text("other")), UnsoundData);
}

TEST_F(ArtifactStoreTest, TwoResultsForOneKeyAreADeterminismBug) {
  const Digest content = write();
  Artifact other = varied_artifact();
  other.attributes["energy"] = 0.2;
  EXPECT_THROW(store_.write("rays", kKey, other, {3, "eq. 8"}), DeterminismError);
  EXPECT_EQ(store_.check("rays", kKey), content);
}

TEST_F(ArtifactStoreTest, AnotherArtifactUnderThisNameIsForeign) {
  const Digest content = write();
  const Digest other_key = hash_text("another key");
  fs::create_directories(folder_.path() / "artifacts" / "samples");
  fs::copy_file(file(), store_.path("rays", other_key));
  fs::copy_file(file(), store_.path("samples", kKey));
  EXPECT_THROW((void)store_.read("rays", other_key, content), UnsoundData);
  EXPECT_THROW((void)store_.read("samples", kKey, content), UnsoundData);
  EXPECT_EQ(store_.check("rays", other_key), std::nullopt);
  EXPECT_EQ(store_.check("samples", kKey), std::nullopt);
  EXPECT_FALSE(fs::exists(store_.path("rays", other_key)));
  EXPECT_TRUE(fs::exists(file()));
}

TEST_F(ArtifactStoreTest, DamagedFilesAreRemovedAndMadeAgain) {
  const Digest content = write();
  const std::string sound = read_text(file());
  std::string flipped = sound;
  flipped[flipped.size() / 2] ^= 4;
  const std::string damaged[] = {"",      "hello",     sound.substr(0, sound.size() - 1),
                                 flipped, sound + "x", std::string(sound.size(), '\0')};
  for (const std::string& bytes : damaged) {
    write_text(file(), bytes);
    EXPECT_THROW((void)store_.read("rays", kKey, content), UnsoundData);
    EXPECT_EQ(store_.check("rays", kKey), std::nullopt);
    EXPECT_FALSE(fs::exists(file()));
    EXPECT_EQ(write(), content);
    EXPECT_EQ(read_text(file()), sound);
  }
}

TEST_F(ArtifactStoreTest, WriteReplacesADamagedFile) {
  const Digest content = write();
  write_text(file(), "hello");
  EXPECT_EQ(write(), content);
  EXPECT_EQ(store_.check("rays", kKey), content);
}

TEST_F(ArtifactStoreTest, TheSameBytesInAnyFolder) {
  write();
  const std::string here = read_text(file());
  const fs::path elsewhere = folder_.path() / "elsewhere";
  fs::create_directories(elsewhere);
  ArtifactStore other(disk_, elsewhere);
  other.write("rays", kKey, varied_artifact(), {3, "eq. 8"});
  EXPECT_EQ(read_text(other.path("rays", kKey)), here);
}

TEST_F(ArtifactStoreTest, RemovesTemporariesAndNothingElse) {
  write();
  const fs::path left_over = file().string() + ".123.456.tmp";
  const fs::path stranger = file().parent_path() / "notes.txt";
  write_text(left_over, "half");
  write_text(stranger, "mine");
  store_.remove_temporaries();
  EXPECT_FALSE(fs::exists(left_over));
  EXPECT_TRUE(fs::exists(stranger));
  EXPECT_TRUE(fs::exists(file()));
  store_.remove_all();
  EXPECT_TRUE(fs::exists(stranger));
  EXPECT_FALSE(fs::exists(file()));
}

TEST_F(ArtifactStoreTest, RefusesStagesThatLeaveTheFolder) {
  for (const char* stage : {"", "..", "a/b", "."}) {
    EXPECT_THROW((void)store_.path(stage, kKey), std::logic_error) << stage;
  }
}

TEST_F(ArtifactStoreTest, ADiskThatTakesNoMoreIsToldAndLeavesNothing) {
  // A limit on the size of files stands in for a full disk: write(2) fails half way.
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{1000, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  std::string message;
  try {
    write();
  } catch (const FileError& error) {
    message = error.what();
  }
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_NE(message.find("cannot write: File too large"), std::string::npos) << message;
  EXPECT_NE(message.find(folder_.path().string()), std::string::npos) << message;
  EXPECT_TRUE(disk_.list(file().parent_path()).empty());
}

TEST(FileSystemTest, ErrorsNamePathReasonAndRemedy) {
  EXPECT_STREQ(FileError("/a/b", "write", ENOSPC).what(),
               "/a/b: cannot write: No space left on device; free some space and run the same "
               "command again");
  EXPECT_STREQ(FileError("/a/b", "write", EROFS).what(),
               "/a/b: cannot write: Read-only file system; make it accessible or choose another "
               "folder");
}

TEST(FileSystemTest, MissingThingsAreNoErrorsWhereAskedFor) {
  const TemporaryFolder folder;
  PosixFileSystem disk;
  const auto nothing = folder.path() / "nothing";
  EXPECT_EQ(disk.size(nothing), std::nullopt);
  EXPECT_EQ(disk.size(folder.path()), std::nullopt);
  EXPECT_FALSE(disk.remove(nothing));
  EXPECT_TRUE(disk.list(nothing).empty());
  EXPECT_THROW(disk.read(nothing), FileError);
  EXPECT_THROW(disk.read(folder.path()), FileError);
  write_text(nothing, "a file");
  EXPECT_THROW(disk.make_dirs(nothing), FileError);
  EXPECT_THROW(disk.make_dirs(nothing / "below"), FileError);
  EXPECT_THROW(disk.create(nothing / "below"), FileError);
}

TEST(FileSystemTest, AppendsAtTheEnd) {
  const TemporaryFolder folder;
  PosixFileSystem disk;
  const auto path = folder.path() / "log";
  disk.open_append(path)->append(std::string_view("one"));
  disk.open_append(path)->append(std::string_view("two"));
  EXPECT_EQ(read_text(path), "onetwo");
  disk.create(path)->append(std::string_view("new"));
  EXPECT_EQ(read_text(path), "new");
}

/// Reads back other bytes than were written.
class LyingFileSystem : public PosixFileSystem {
 public:
  std::vector<std::byte> read(const Path& path) override {
    auto bytes = PosixFileSystem::read(path);
    if (!bytes.empty()) bytes[0] ^= std::byte{1};
    return bytes;
  }
};

TEST(FileSystemTest, AFileThatReadsBackDifferentlyNeverGetsItsName) {
  const TemporaryFolder folder;
  LyingFileSystem disk;
  const auto path = folder.path() / "file";
  const std::byte bytes[] = {std::byte{1}, std::byte{2}};
  EXPECT_THROW(replace_file(disk, path, bytes), FileError);
  EXPECT_TRUE(disk.list(folder.path()).empty());
}

TEST(FileSystemTest, ALockHoldsUntilItsOwnerEnds) {
  const TemporaryFolder folder;
  PosixFileSystem disk;
  const auto path = folder.path() / "lock";
  auto first = disk.lock(path, "the first");
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(disk.lock(path, "the second"), nullptr);
  EXPECT_EQ(read_text(path), "the first");
  first.reset();
  EXPECT_NE(disk.lock(path, "2"), nullptr);
  EXPECT_EQ(read_text(path), "2");
}

TEST(FileSystemTest, AKilledProcessLeavesNoLock) {
  const TemporaryFolder folder;
  PosixFileSystem disk;
  const auto path = folder.path() / "lock";
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    const auto lock = PosixFileSystem().lock(path, "the child");
    const char told = lock ? 'y' : 'n';
    if (write(ready[1], &told, 1) != 1) _exit(1);
    while (true) pause();
  }
  char told = 0;
  ASSERT_EQ(read(ready[0], &told, 1), 1);
  EXPECT_EQ(told, 'y');
  EXPECT_EQ(disk.lock(path, "us"), nullptr);
  kill(child, SIGKILL);
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_NE(disk.lock(path, "us"), nullptr);
  close(ready[0]);
  close(ready[1]);
}

}  // namespace
}  // namespace prt
