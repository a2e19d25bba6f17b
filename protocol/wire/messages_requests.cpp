#include <tandem_wire/requests_t.hpp>

#include "protocol/wire/codec.h"
#include "protocol/wire/messages.h"

namespace tandem::wire {
namespace {

constexpr std::size_t kSideBytes = 4 + 4;  ///< before each request: process and size

}  // namespace

void begin_requests(Bytes& message) { codec::begin(tandem_wire::requests_t{}, {{0, 1}}, message); }

void append(Process side, ByteView request, Bytes& message) {
  const std::size_t at = message.size();
  message.resize(at + kSideBytes);
  codec::write_word(static_cast<std::size_t>(side), message.data() + at);
  codec::write_word(request.size(), message.data() + at + 4);
  message.insert(message.end(), request.begin(), request.end());
}

void end_requests(const Header& header, Bytes& message) {
  tandem_wire::requests_t fixed{};
  fixed.header = codec::pack(header);
  const auto fixed_bytes = static_cast<std::size_t>(fixed.getEncodedSize());
  fixed.encode(message.data(), 0, static_cast<int>(fixed_bytes));
  codec::write_counts({{message.size() - fixed_bytes, 1}}, message.data());
}

std::optional<ByteView> request_to(Process side, ByteView message) {
  const auto fixed = codec::fixed_part<tandem_wire::requests_t>(message, {1});
  if (!fixed) return std::nullopt;
  const Header whole = codec::unpack(fixed->header);
  ByteView found;
  for (ByteView rest = message.last(codec::count_at(message, 0)); !rest.empty();) {
    if (rest.size() < kSideBytes) return std::nullopt;
    const std::size_t process = codec::read_word(rest.data());
    const std::size_t size = codec::read_word(rest.data() + 4);
    rest = rest.subspan(kSideBytes);
    if (size < kHeaderEnd || size > rest.size()) return std::nullopt;
    const ByteView request = rest.first(size);
    rest = rest.subspan(size);
    if (process != static_cast<std::size_t>(side)) continue;
    const Header own = header_of(request);
    const bool fits =
        own.kind == Kind::Request && own.run_id == whole.run_id && own.sender == whole.sender;
    if (!fits || !found.empty()) return std::nullopt;
    found = request;
  }
  return found;
}

}  // namespace tandem::wire
