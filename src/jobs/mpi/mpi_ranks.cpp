#include "jobs/mpi/mpi_ranks.h"

#include <mpi.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <list>
#include <map>
#include <stdexcept>
#include <thread>

namespace prt {

namespace {

constexpr int kTag = 1;
/// At the end a receiver that is gone must not hold us for ever.
constexpr std::chrono::seconds kLastSends{5};

class MpiLink : public Link {
 public:
  MpiLink() {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
  }
  [[nodiscard]] int rank() const override { return rank_; }
  [[nodiscard]] int size() const override { return size_; }

  void send(WorkerId to, std::string text) override {
    drop_sent();
    Sending& sending = sending_.emplace_back();
    sending.text = std::move(text);
    MPI_Isend(sending.text.data(), static_cast<int>(sending.text.size()), MPI_BYTE, to, kTag,
              MPI_COMM_WORLD, &sending.request);
  }

  std::optional<Message> poll() override {
    drop_sent();
    int there = 0;
    MPI_Message handle = MPI_MESSAGE_NULL;
    MPI_Status status;
    // Open MPI looks among what it has taken in and only then takes in more: what came while we
    // slept is found by a second look, and without it a round later. A coordinator whose rounds are
    // long would judge silence by messages of the round before the last.
    for (int look = 0; look < 2 && there == 0; ++look) {
      MPI_Improbe(MPI_ANY_SOURCE, kTag, MPI_COMM_WORLD, &there, &handle, &status);
    }
    if (there == 0) return std::nullopt;
    int bytes = 0;
    MPI_Get_count(&status, MPI_BYTE, &bytes);
    Message message{status.MPI_SOURCE, std::string(static_cast<std::size_t>(bytes), '\0')};
    MPI_Mrecv(message.text.data(), bytes, MPI_BYTE, &handle, MPI_STATUS_IGNORE);
    return message;
  }

  /// Waits until all that was sent has left.
  void flush() {
    const auto end = std::chrono::steady_clock::now() + kLastSends;
    for (drop_sent(); !sending_.empty(); drop_sent()) {
      if (std::chrono::steady_clock::now() > end) return;
      std::this_thread::yield();
    }
  }

 private:
  struct Sending {
    std::string text;
    MPI_Request request = MPI_REQUEST_NULL;
  };

  void drop_sent() {
    std::erase_if(sending_, [](Sending& s) {
      int sent = 0;
      MPI_Test(&s.request, &sent, MPI_STATUS_IGNORE);
      return sent != 0;
    });
  }

  int rank_ = 0;
  int size_ = 1;
  std::list<Sending> sending_;  // a buffer must not move while MPI reads it
};

class MpiRanks : public Ranks {
 public:
  MpiRanks() {
    // Cross-memory attach can hang in containers, and messages of a few KB gain nothing from it.
    setenv("OMPI_MCA_btl_vader_single_copy_mechanism", "none", 0);
    int provided = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
    if (provided < MPI_THREAD_FUNNELED) throw std::runtime_error("this MPI knows no threads");
    link_ = std::make_unique<MpiLink>();
    MPI_Comm node = MPI_COMM_NULL;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
    MPI_Comm_rank(node, &node_rank_);
    MPI_Comm_size(node, &node_size_);
    meet_neighbours(node);
    MPI_Comm_free(&node);
  }
  ~MpiRanks() override { finish(); }
  MpiRanks(const MpiRanks&) = delete;
  MpiRanks& operator=(const MpiRanks&) = delete;

  [[nodiscard]] int rank() const override { return link_->rank(); }
  [[nodiscard]] int size() const override { return link_->size(); }
  [[nodiscard]] int node_rank() const override { return node_rank_; }
  [[nodiscard]] int node_size() const override { return node_size_; }

  std::string broadcast(std::string text) override {
    int bytes = static_cast<int>(text.size());
    MPI_Bcast(&bytes, 1, MPI_INT, 0, MPI_COMM_WORLD);
    text.resize(static_cast<std::size_t>(bytes));
    MPI_Bcast(text.data(), bytes, MPI_BYTE, 0, MPI_COMM_WORLD);
    return text;
  }

  std::vector<std::string> gather_all(const std::string& text) override {
    const auto ranks = static_cast<std::size_t>(size());
    const int bytes = static_cast<int>(text.size());
    std::vector<int> counts(ranks);
    MPI_Allgather(&bytes, 1, MPI_INT, counts.data(), 1, MPI_INT, MPI_COMM_WORLD);
    std::vector<int> offsets(ranks, 0);
    for (std::size_t r = 1; r < ranks; ++r) offsets[r] = offsets[r - 1] + counts[r - 1];
    std::string all(static_cast<std::size_t>(offsets.back() + counts.back()), '\0');
    MPI_Allgatherv(text.data(), bytes, MPI_BYTE, all.data(), counts.data(), offsets.data(),
                   MPI_BYTE, MPI_COMM_WORLD);
    std::vector<std::string> texts;
    for (std::size_t r = 0; r < ranks; ++r) {
      texts.push_back(
          all.substr(static_cast<std::size_t>(offsets[r]), static_cast<std::size_t>(counts[r])));
    }
    return texts;
  }

  Link& link() override { return *link_; }

  void finish() override {
    if (finished_) return;
    finished_ = true;
    link_->flush();
    MPI_Finalize();
  }

  [[noreturn]] void abort(int code) override {
    link_->flush();
    MPI_Abort(MPI_COMM_WORLD, code);
    std::_Exit(code);
  }

  [[noreturn]] void abort_without(const std::vector<int>& lost, int code) override {
    link_->flush();
    for (const int rank : lost) {
      const auto neighbour = neighbours_.find(rank);
      if (neighbour == neighbours_.end()) continue;
      syscall(SYS_pidfd_send_signal, neighbour->second, SIGKILL, nullptr, 0);
    }
    abort(code);
  }

 private:
  /// Opens handles to the processes of this machine's other ranks: unlike their numbers, they never
  /// come to mean another process.
  void meet_neighbours(MPI_Comm node) {
    const std::array<int, 2> own = {rank(), static_cast<int>(getpid())};
    std::vector<int> all(2 * static_cast<std::size_t>(node_size_));
    MPI_Allgather(own.data(), 2, MPI_INT, all.data(), 2, MPI_INT, node);
    for (std::size_t i = 0; i < all.size(); i += 2) {
      if (all[i] == rank()) continue;
      const long handle = syscall(SYS_pidfd_open, all[i + 1], 0);
      if (handle >= 0) neighbours_[all[i]] = static_cast<int>(handle);
    }
  }

  std::map<int, int> neighbours_;  ///< rank → process handle
  std::unique_ptr<MpiLink> link_;
  int node_rank_ = 0;
  int node_size_ = 1;
  bool finished_ = false;
};

}  // namespace

bool launched_as_rank() {
  return std::ranges::any_of(
      std::initializer_list<const char*>{"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK"},
      [](const char* name) { return std::getenv(name) != nullptr; });
}

std::unique_ptr<Ranks> make_mpi_ranks() { return std::make_unique<MpiRanks>(); }

}  // namespace prt
