#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "protocol/contract/error.h"
#include "protocol/wire/journal.h"
#include "protocol/wire/seal.h"

namespace tandem::wire {

/// Number of the wire format; both ends of a handshake compare it.
inline constexpr std::int32_t kProtocolVersion = 9;

enum class RequestKind : std::int32_t {
  Initialize = 0,
  Advance = 1,
  Observe = 2,
  Bye = 3,
  Command = 4
};

/// One call to a side. Which of motions and wrenches is filled depends on the side.
///
/// An advance whose segment begins where the last accepted one ended has an empty `begin`: both
/// ends keep that value, so it need not travel again.
struct Request {
  Header header;
  RequestKind call = RequestKind::Observe;
  bool checkpoint_first = false;
  bool rollback_first = false;
  bool linearize = false;
  SimTime step{};
  Segment<MotionSet> motions;
  Segment<WrenchSet> wrenches;
  std::string command;  ///< Command: its text; the reply's outcome is Failed when it was refused
};

/// A request whose arrays stay where they are: `head` without its segments.
struct RequestView {
  Request& head;
  std::span<const Motion> motions_begin, motions_end;
  std::span<const Wrench> wrenches_begin, wrenches_end;
};

/// Time the serving process books for one request (s).
struct ServerCost {
  double compute_s = 0.0;
  double decode_s = 0.0;
  double encode_s = 0.0;
  double publish_s = 0.0;  ///< of the previous reply
};

struct Reply {
  Header header;
  ServerCost cost;
  std::int64_t duplicates = 0;  ///< requests that came again, since the run began
  Outcome outcome = Outcome::Done;
  std::optional<ErrorKind> error;  ///< the side threw; `message` is its text
  std::string message;
  std::int32_t solver_iterations = 0;
  double output_error_N = 0.0;
  std::optional<InterfaceJacobian> jacobian;
  Observation observation;
  MotionSet motions;
  WrenchSet wrenches;
};

/// hello says what the driver expects of the ports; welcome says what the side is.
struct Handshake {
  Header header;
  std::int32_t protocol_version = kProtocolVersion;
  std::string tandem_version;
  std::uint64_t scenario_hash = 0;
  std::vector<PortInfo> ports;
  SimTime micro_step{};
  bool can_linearize = false;
  std::int32_t receive_buffer_bytes = 0;
  std::int32_t process_id = 0;
  std::string refusal;  ///< why the side refuses; empty = welcome
};

struct Alive {
  Header header;
  std::int32_t process_id = 0;
  std::string phase;
};

struct Abort {
  Header header;
  std::int32_t exit_code = 0;
  std::string text;
};

struct Credit {
  Header header;
  std::int64_t recorded_through = 0;
  std::int64_t wanted = 0;
};

/// A command to the flexible side of a running pair; header.sequence names it.
struct Control {
  Header header;
  std::string text;
};

/// The driver's answer; header.macro_step is the first that the command acts on.
struct Controlled {
  Header header;
  bool accepted = false;
  std::string message;
};

struct Chunk {
  Header header;
  Kind whole_kind = Kind::Journal;
  std::uint32_t whole_checksum = 0;
  std::int32_t whole_bytes = 0;
  std::int32_t index = 0;
  std::int32_t count = 0;
  bool ends_burst = false;  ///< no more parts come before they are asked for
  ByteView bytes;           ///< lies in the message that was decoded
};

/// The parts of a message in chunks that its receiver lacks; header.sequence is that message's.
struct Missing {
  Header header;
  Kind whole_kind = Kind::Journal;
  std::uint32_t whole_checksum = 0;
  std::vector<std::int32_t> wanted;
};

struct ScenarioText {
  std::string scenario_yaml;
  std::string versions;
};

/// Encoding to big-endian LCM bytes; values cross bit for bit. The result is not sealed yet. The
/// two messages of an exchange are written into a buffer that the caller keeps.
void encode(const RequestView& request, Bytes& message);
void encode(const Reply& reply, Bytes& message);
[[nodiscard]] Bytes encode(const Request& request);
[[nodiscard]] Bytes encode(const Reply& reply);
[[nodiscard]] Bytes encode(const Handshake& handshake);
[[nodiscard]] Bytes encode(const Alive& alive);
[[nodiscard]] Bytes encode(const Abort& abort);
[[nodiscard]] Bytes encode(const Credit& credit);
/// What stands before the bytes of a chunk; `size` of them follow.
inline constexpr std::size_t kChunkHead = kHeaderEnd + 7 * 4;
void encode_head(const Chunk& chunk, std::size_t size, std::span<std::uint8_t, kChunkHead> head);
[[nodiscard]] Bytes encode(const Missing& missing);
[[nodiscard]] Bytes encode(const Control& control);
[[nodiscard]] Bytes encode(const Controlled& controlled);
/// Messages of the journal: macro step and iteration of the header are those of the record.
/// A call may be encoded without the begin of its input: AcceptedInputs.
void encode(const Header& header, const CallRecord& call, Bytes& message,
            bool without_begin = false);
/// A journal message carries any number of macro steps: begin, append each, end with the header.
void begin_journal(Bytes& message);
void append(const StepJournal& journal, Bytes& message);
/// The same, leaving out what `accepted` knows; takes the accepted inputs out of the journal.
void append(StepJournal&& journal, AcceptedInputs& accepted, Bytes& message);
void end_journal(const Header& header, Bytes& message);
/// Requests to several sides in one message: begin, append each as it is encoded, end with the
/// header.
void begin_requests(Bytes& message);
void append(Process side, ByteView request, Bytes& message);
void end_requests(const Header& header, Bytes& message);
[[nodiscard]] Bytes encode(const Header& header, const StepRecord& step);
[[nodiscard]] Bytes encode(const Header& header, const Finished& finished);
[[nodiscard]] Bytes encode(const Header& header, const ScenarioText& scenario);

/// Into memory of their own: for single messages and tests.
[[nodiscard]] inline Bytes encode(const Header& header, const CallRecord& call) {
  Bytes message;
  encode(header, call, message);
  return message;
}
[[nodiscard]] inline Bytes encode(const Header& header, const StepJournal& journal) {
  Bytes message;
  begin_journal(message);
  append(journal, message);
  end_journal(header, message);
  return message;
}

/// Decoding of a message whose seal was good. Nothing when the fingerprint is that of another
/// schema, when the lengths it states do not add up to its size, or a value is outside its range.
[[nodiscard]] std::optional<Request> decode_request(ByteView message);
[[nodiscard]] std::optional<Reply> decode_reply(ByteView message);
/// The same into an object whose memory is used again; false = nothing.
[[nodiscard]] bool decode(ByteView message, Request& request);
[[nodiscard]] bool decode(ByteView message, Reply& reply);
/// The one to `side` out of requests to several, lying in that message; empty: there is none.
[[nodiscard]] std::optional<ByteView> request_to(Process side, ByteView message);
[[nodiscard]] std::optional<Handshake> decode_handshake(ByteView message);
[[nodiscard]] std::optional<Alive> decode_alive(ByteView message);
[[nodiscard]] std::optional<Abort> decode_abort(ByteView message);
[[nodiscard]] std::optional<Credit> decode_credit(ByteView message);
[[nodiscard]] std::optional<Chunk> decode_chunk(ByteView message);
[[nodiscard]] std::optional<Missing> decode_missing(ByteView message);
[[nodiscard]] std::optional<Control> decode_control(ByteView message);
[[nodiscard]] std::optional<Controlled> decode_controlled(ByteView message);
[[nodiscard]] std::optional<CallRecord> decode_call(ByteView message);
[[nodiscard]] std::optional<SideName> side_of_call(ByteView message);  ///< without the rest
[[nodiscard]] std::optional<StepRecord> decode_step(ByteView message);
[[nodiscard]] std::optional<std::vector<StepJournal>> decode_journal(ByteView message);
/// The same with the events as received, which share the message.
[[nodiscard]] std::optional<std::vector<StepJournal>> decode_journal(
    const std::shared_ptr<Bytes>& message);
[[nodiscard]] std::optional<Finished> decode_finished(ByteView message);
[[nodiscard]] std::optional<ScenarioText> decode_scenario(ByteView message);

/// Offset of ServerCost::encode_s in an encoded reply: it is known only after encoding.
inline constexpr std::size_t kReplyEncodeAt = kHeaderEnd + 4 * 4 + 2 * 8;

}  // namespace tandem::wire
