// How ranks talk once they run: whole messages, in order per pair, never blocking.
#pragma once

#include <optional>
#include <string>

#include "jobs/protocol.h"

namespace prt {

class Link {
 public:
  virtual ~Link() = default;
  struct Message {
    WorkerId from = 0;
    std::string text;
  };
  [[nodiscard]] virtual int rank() const = 0;
  [[nodiscard]] virtual int size() const = 0;
  virtual void send(WorkerId to, std::string text) = 0;
  /// The next message that has arrived, if any.
  virtual std::optional<Message> poll() = 0;
};

/// A rank on its own: nobody to talk to.
class NoLink : public Link {
 public:
  [[nodiscard]] int rank() const override { return 0; }
  [[nodiscard]] int size() const override { return 1; }
  void send(WorkerId, std::string) override {}
  std::optional<Message> poll() override { return std::nullopt; }
};

}  // namespace prt
