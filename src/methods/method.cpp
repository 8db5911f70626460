#include "methods/method.h"

namespace prt {

std::shared_ptr<void> Memo::get_any(const std::string& name,
                                    const std::function<std::shared_ptr<void>()>& make) {
  std::shared_ptr<Slot> slot;
  {
    const std::lock_guard lock(mutex_);
    std::shared_ptr<Slot>& known = slots_[name];
    if (!known) known = std::make_shared<Slot>();
    slot = known;
  }
  // One thread makes the value while the others that want it wait; if it throws, the next one
  // tries.
  const std::lock_guard lock(slot->mutex);
  if (!slot->value) slot->value = make();
  return slot->value;
}

void Memo::trim() {
  const std::lock_guard lock(mutex_);
  // A slot somebody else holds is being filled or read; a value somebody else holds would only be
  // made twice.
  std::erase_if(slots_, [](const auto& entry) {
    const std::shared_ptr<Slot>& slot = entry.second;
    return slot.use_count() == 1 && slot->value.use_count() <= 1;
  });
}

}  // namespace prt
