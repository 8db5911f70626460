// Runs programs as a user would: a child process in a session of its own, with its output in a
// file.
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace prt::test {

namespace fs = std::filesystem;

inline std::string read_text(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// A fresh folder that goes with the object.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "prt-XXXXXX").string();
    path = mkdtemp(name.data());
  }
  ~TemporaryFolder() { fs::remove_all(path); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  fs::path path;
};

/// All processes below `root`, itself included, children before parents.
inline std::vector<pid_t> process_tree(pid_t root) {
  std::multimap<pid_t, pid_t> children;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    const std::string stat = read_text(entry.path() / "stat");
    const std::size_t close = stat.rfind(')');
    if (close == std::string::npos) continue;
    char state = 0;
    pid_t parent = 0;
    std::istringstream(stat.substr(close + 1)) >> state >> parent;
    children.emplace(parent, static_cast<pid_t>(std::stol(name)));
  }
  std::vector<pid_t> tree;
  const std::function<void(pid_t)> visit = [&](pid_t process) {
    const auto [first, last] = children.equal_range(process);
    for (auto it = first; it != last; ++it) visit(it->second);
    tree.push_back(process);
  };
  visit(root);
  return tree;
}

class Program {
 public:
  Program(const std::vector<std::string>& command, const fs::path& log,
          const std::map<std::string, std::string>& environment = {})
      : log_(log) {
    std::vector<char*> arguments;
    arguments.reserve(command.size() + 1);
    for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    process_ = fork();
    if (process_ != 0) return;
    setsid();
    const int out = open(log.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0644);
    dup2(out, STDOUT_FILENO);
    dup2(out, STDERR_FILENO);
    for (const auto& [name, value] : environment) setenv(name.c_str(), value.c_str(), 1);
    execvp(arguments[0], arguments.data());
    _exit(127);
  }
  ~Program() {
    if (process_ > 0 && !finished()) kill_all();
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// Exit code, or -signal; waits for the end.
  int wait() {
    if (!status_) {
      int status = 0;
      waitpid(process_, &status, 0);
      status_ = status;
    }
    return WIFEXITED(*status_) ? WEXITSTATUS(*status_) : -WTERMSIG(*status_);
  }

  [[nodiscard]] bool finished() {
    int status = 0;
    if (!status_ && waitpid(process_, &status, WNOHANG) == process_) status_ = status;
    return status_.has_value();
  }

  [[nodiscard]] pid_t process() const { return process_; }
  void send(int signal) const { kill(process_, signal); }

  /// SIGKILL to every process of the job at once, as a failing machine would.
  void kill_all() {
    const std::vector<pid_t> tree = process_tree(process_);
    for (const pid_t p : tree) kill(p, SIGSTOP);  // nobody reacts to another's death
    for (const pid_t p : tree) kill(p, SIGKILL);
    wait();
  }

  [[nodiscard]] std::string output() const { return read_text(log_); }

 private:
  fs::path log_;
  pid_t process_ = -1;
  std::optional<int> status_;
};

/// A bake's start, with what each test varies.
struct BakeRun {
  int ranks = 0;  ///< 0: without mpirun
  int threads = 1;
  std::vector<std::string> more = {};
  std::map<std::string, std::string> environment = {};
  std::vector<std::string> mpirun_options = {};
};
using ToyRun = BakeRun;

/// Starts `bake` (program and arguments) on the run's ranks.
inline std::unique_ptr<Program> start_bake(const std::vector<std::string>& bake, const BakeRun& run,
                                           const fs::path& mpirun, const fs::path& log) {
  std::vector<std::string> command;
  std::map<std::string, std::string> environment = run.environment;
  if (run.ranks > 0) {
    command = {mpirun.string(),   "-n",        std::to_string(run.ranks),
               "--oversubscribe", "--bind-to", "none"};
    command.insert(command.end(), run.mpirun_options.begin(), run.mpirun_options.end());
    environment["OMPI_ALLOW_RUN_AS_ROOT"] = "1";
    environment["OMPI_ALLOW_RUN_AS_ROOT_CONFIRM"] = "1";
  }
  command.insert(command.end(), bake.begin(), bake.end());
  command.insert(command.end(), {"--threads", std::to_string(run.threads)});
  command.insert(command.end(), run.more.begin(), run.more.end());
  return std::make_unique<Program>(command, log, environment);
}

/// Artifacts that are on disk; a bake may be writing more meanwhile.
inline std::size_t count_artifacts(const fs::path& bake) {
  std::size_t count = 0;
  std::error_code error;
  for (const auto& stage : fs::directory_iterator(bake / "artifacts", error)) {
    for (const auto& file : fs::directory_iterator(stage, error)) {
      count += file.path().extension() == ".h5" ? 1 : 0;
    }
  }
  return count;
}

/// Size and hash of all artifacts and the package of a bake, by path within it.
inline std::map<std::string, std::string> bake_results(const fs::path& bake) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(bake)) {
    const std::string extension = entry.path().extension().string();
    const bool artifact = entry.path().string().find("/artifacts/") != std::string::npos;
    if (entry.is_regular_file() && (artifact || extension == ".glb")) {
      const std::string content = read_text(entry.path());
      files[fs::relative(entry.path(), bake).string()] =
          std::to_string(content.size()) + " bytes, " +
          std::to_string(std::hash<std::string>{}(content));
    }
  }
  return files;
}

class ToyFolder : public TemporaryFolder {
 public:
  explicit ToyFolder(const std::string& options = "toy: {leaves: 40}") {
    std::ofstream(path / "toy.scene") << "a triangle";
    std::ofstream(path / "toy.yaml") << "scene: toy.scene\noutput: bake\n" << options << "\n";
  }

  [[nodiscard]] fs::path bake() const { return path / "bake"; }

  [[nodiscard]] std::unique_ptr<Program> start(const ToyRun& run, const fs::path& mpirun) const {
    return start_bake({std::string(PRT_BINARY_DIR) + "/bin/toy_bake", (path / "toy.yaml").string()},
                      run, mpirun, path / "log.txt");
  }

  [[nodiscard]] std::map<std::string, std::string> results() const { return bake_results(bake()); }

  [[nodiscard]] std::size_t count_artifacts() const { return test::count_artifacts(bake()); }
};

}  // namespace prt::test
