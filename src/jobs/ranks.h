// The ranks of a job at start-up: who is there, and the few collective exchanges that come before
// work begins. Once a bake runs, ranks talk through Link only.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "jobs/link.h"

namespace prt {

class Ranks {
 public:
  virtual ~Ranks() = default;
  [[nodiscard]] virtual int rank() const = 0;
  [[nodiscard]] virtual int size() const = 0;
  /// Number of this rank among those on the same machine, and how many those are.
  [[nodiscard]] virtual int node_rank() const = 0;
  [[nodiscard]] virtual int node_size() const = 0;
  /// Rank 0's text on every rank. Collective.
  virtual std::string broadcast(std::string text) = 0;
  /// Every rank's text, by rank. Collective.
  virtual std::vector<std::string> gather_all(const std::string& text) = 0;
  virtual Link& link() = 0;
  /// Leaves the job in an orderly way: what was sent has arrived. No message after that.
  virtual void finish() = 0;
  /// Ends the whole job now.
  [[noreturn]] virtual void abort(int code) = 0;
  /// The same where some ranks do not answer: first those of them on this machine are killed, as
  /// the launcher would wait for one that hangs. One that hangs on another machine is left to
  /// whoever watches the launcher.
  [[noreturn]] virtual void abort_without(const std::vector<int>& lost, int code) = 0;
};

/// One process without mpirun; needs no MPI.
std::unique_ptr<Ranks> make_single_rank();

}  // namespace prt
