#include "apps/bake/cpu_share.h"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string_view>

namespace prt {

namespace {

int count_cpus(pid_t process) {
  cpu_set_t set;
  CPU_ZERO(&set);
  return sched_getaffinity(process, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 0;
}

/// Open MPI bound this process by its own default, not because the user said so.
bool bound_by_default() {
  const auto is_set = [](const char* name) { return std::getenv(name) != nullptr; };
  return is_set("OMPI_MCA_orte_bound_at_launch") && !is_set("OMPI_MCA_hwloc_base_binding_policy") &&
         !is_set("OMPI_MCA_hwloc_base_cpu_set") && !is_set("OMPI_MCA_rmaps_rank_file_path");
}

struct Process {
  std::string name;
  pid_t parent = 0;
};

Process look_at(pid_t process) {
  std::ifstream in("/proc/" + std::to_string(process) + "/stat");
  std::string text;
  std::getline(in, text);
  // "pid (name) state ppid ...": the name may hold blanks and brackets.
  const std::size_t open = text.find('(');
  const std::size_t close = text.rfind(')');
  if (open == std::string::npos || close == std::string::npos) return {};
  Process found{text.substr(open + 1, close - open - 1), 0};
  char state = 0;
  std::istringstream(text.substr(close + 1)) >> state >> found.parent;
  return found;
}

/// The daemon of the launcher on this machine, which is never bound itself; 0 if there is none.
pid_t launcher() {
  constexpr std::array<std::string_view, 5> kNames{"mpirun", "orterun", "orted", "prterun",
                                                   "prted"};
  constexpr int kMostAncestors = 16;
  pid_t process = getppid();
  for (int i = 0; i < kMostAncestors && process > 1; ++i) {
    const Process found = look_at(process);
    if (std::ranges::find(kNames, found.name) != kNames.end()) return process;
    process = found.parent;
  }
  return 0;
}

bool widen_default_binding() {
  if (!bound_by_default()) return false;
  const pid_t parent = launcher();
  cpu_set_t set;
  CPU_ZERO(&set);
  if (parent == 0 || sched_getaffinity(parent, sizeof set, &set) != 0) return false;
  if (CPU_COUNT(&set) <= count_cpus(0)) return false;
  return sched_setaffinity(0, sizeof set, &set) == 0;
}

std::string first_line(const std::string& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

/// Smallest quota of this process's cgroups, v2 and v1; 0: none.
int quota_cpus() {
  int least = 0;
  const auto take = [&](const std::string& cpu_max) {
    const int cpus = cpus_of_quota(cpu_max);
    if (cpus > 0 && (least == 0 || cpus < least)) least = cpus;
  };
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    const std::size_t first = line.find(':');
    const std::size_t second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    std::string path = line.substr(second + 1);
    const bool v2 = controllers.empty();
    if (!v2 && ("," + controllers + ",").find(",cpu,") == std::string::npos) continue;
    for (;;) {
      const std::string dir = (v2 ? "/sys/fs/cgroup" : "/sys/fs/cgroup/cpu") + path + "/";
      take(v2 ? first_line(dir + "cpu.max")
              : first_line(dir + "cpu.cfs_quota_us") + " " + first_line(dir + "cpu.cfs_period_us"));
      if (path.empty()) break;
      path.erase(path.rfind('/'));
    }
  }
  return least;
}

int environment_count(const char* name) {
  const char* text = std::getenv(name);
  return text != nullptr ? std::atoi(text) : 0;
}

}  // namespace

int cpus_of_quota(const std::string& cpu_max) {
  double quota = 0.0;
  double period = 0.0;
  std::istringstream in(cpu_max);
  if (!(in >> quota >> period) || quota <= 0.0 || period <= 0.0) return 0;
  return std::max(1, static_cast<int>(std::ceil(quota / period)));
}

CpuShare share_cpus(int ranks_on_node) {
  CpuShare share;
  share.widened = widen_default_binding();
  share.cpus = std::max(1, count_cpus(0));
  for (const int limit : {quota_cpus(), environment_count("SLURM_CPUS_ON_NODE")}) {
    if (limit > 0) share.cpus = std::min(share.cpus, limit);
  }
  // A binding the user asked for is this rank's own share already.
  const bool own_cpus =
      std::getenv("OMPI_MCA_orte_bound_at_launch") != nullptr && !bound_by_default();
  share.threads = own_cpus ? share.cpus : std::max(1, share.cpus / std::max(1, ranks_on_node));
  return share;
}

}  // namespace prt
