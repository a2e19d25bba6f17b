#include <tandem_wire/control_t.hpp>
#include <tandem_wire/controlled_t.hpp>

#include "protocol/wire/codec.h"
#include "protocol/wire/messages.h"

namespace tandem::wire {

using codec::count;
using codec::from_bytes;
using codec::pack;
using codec::to_bytes;
using codec::unpack;

Bytes encode(const Control& control) {
  tandem_wire::control_t packed;
  packed.header = pack(control.header);
  packed.text = pack(control.text);
  packed.n_text = count(packed.text);
  return to_bytes(packed);
}

std::optional<Control> decode_control(ByteView message) {
  const auto packed = from_bytes(message, tandem_wire::control_t{}, {1});
  if (!packed) return std::nullopt;
  return Control{.header = unpack(packed->header), .text = unpack(packed->text)};
}

Bytes encode(const Controlled& controlled) {
  tandem_wire::controlled_t packed;
  packed.header = pack(controlled.header);
  packed.accepted = controlled.accepted;
  packed.message = pack(controlled.message);
  packed.n_message = count(packed.message);
  return to_bytes(packed);
}

std::optional<Controlled> decode_controlled(ByteView message) {
  const auto packed = from_bytes(message, tandem_wire::controlled_t{}, {1});
  if (!packed) return std::nullopt;
  return Controlled{.header = unpack(packed->header),
                    .accepted = packed->accepted != 0,
                    .message = unpack(packed->message)};
}

}  // namespace tandem::wire
