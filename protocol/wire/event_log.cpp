#include "protocol/wire/event_log.h"

#include <fmt/format.h>
#include <lcm/lcm.h>
#include <sys/stat.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <iterator>
#include <string_view>

#include "protocol/contract/error.h"

namespace tandem::wire {
namespace {

constexpr std::uint32_t kMagic = 0xEDA1DA01;
constexpr std::size_t kEventHeader = 28;  // magic, number, time stamp, two lengths; big endian
constexpr std::int64_t kMaxChannel = 63;
constexpr std::int64_t kMaxPayload = 256 << 20;

std::uint64_t big_endian(const std::uint8_t* bytes, int count) {
  std::uint64_t value = 0;
  for (int i = 0; i < count; ++i) value = (value << 8U) | bytes[i];
  return value;
}

std::string channel_of(std::uint64_t run_id, Process topic, Kind kind) {
  return fmt::format("TANDEM_{:016x}_{}_{}", run_id, text_of(topic), text_of(kind));
}

Process topic_of(SideName side) { return side == SideName::Mbs ? Process::Mbs : Process::Fem; }

// The channel that an event with this content must have.
std::string channel_of(const Header& header, ByteView payload) {
  Process topic = Process::Orchestrator;
  if (header.kind == Kind::Call) {
    if (const auto side = side_of_call(payload)) topic = topic_of(*side);
  }
  return channel_of(header.run_id, topic, header.kind);
}

}  // namespace

struct LogWriter::File {
  explicit File(const std::string& name) : log(lcm_eventlog_create(name.c_str(), "w")) {}
  ~File() {
    if (log != nullptr) lcm_eventlog_destroy(log);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  lcm_eventlog_t* log;
};

LogWriter::LogWriter(const std::filesystem::path& file, std::uint64_t run_id,
                     const ScenarioText& scenario)
    : file_(std::make_unique<File>(file.string())), name_(file.string()), run_id_(run_id) {
  if (file_->log == nullptr) fail();
  event(Process::Orchestrator, Kind::Scenario, scenario);
  flush();
}

LogWriter::~LogWriter() = default;

Header LogWriter::next_header(Kind kind) {
  return {.run_id = run_id_,
          .sequence = number_++,
          .kind = kind,
          .sender = Process::Orchestrator,
          .time_us = wall_clock_us()};
}

template <class Record>
void LogWriter::event(Process topic, Kind kind, const Record& record) {
  const Header header = next_header(kind);
  message_ = encode(header, record);
  seal(message_);
  put(topic, header, message_);
}

void LogWriter::event(const CallRecord& call) {
  const Header header = next_header(Kind::Call);
  encode(header, call, message_, accepted_.is_begin_of(call));
  accepted_.follow(call);
  seal(message_);
  put(topic_of(call.side), header, message_);
}

void LogWriter::event(Process topic, Kind kind, std::span<std::uint8_t> received) {
  const Header given = header_of(received);
  Header header = next_header(kind);
  header.macro_step = given.macro_step;
  header.iteration = given.iteration;
  seal_as(header, received);
  put(topic, header, received);
}

void LogWriter::put(Process topic, const Header& header, std::span<std::uint8_t> message) {
  std::string channel = channel_of(run_id_, topic, header.kind);
  lcm_eventlog_event_t event{};
  event.timestamp = header.time_us;
  event.channellen = static_cast<std::int32_t>(channel.size());
  event.datalen = static_cast<std::int32_t>(message.size());
  event.channel = channel.data();
  event.data = message.data();
  if (lcm_eventlog_write_event(file_->log, &event) != 0) fail();
  bytes_ += static_cast<std::int64_t>(kEventHeader + channel.size() + message.size());
}

// liblcm writes through a buffered stream and flushes at the end only; a full disk shows here.
void LogWriter::flush() {
  if (std::fflush(file_->log->f) != 0) fail();
  require_still_there();
}

void LogWriter::require_still_there() const {
  struct stat status {};
  if (fstat(fileno(file_->log->f), &status) == 0 && status.st_nlink == 0) {
    throw Error(ErrorKind::System,
                fmt::format("log: {} was removed while it was written: nothing of the run is kept.",
                            name_));
  }
}

void LogWriter::fail() const {
  throw Error(ErrorKind::System,
              fmt::format("log: cannot write {} at event {}: {}. Free some space or choose another "
                          "--out.",
                          name_, number_, std::strerror(errno)));
}

void LogWriter::write(const StepJournal& journal) {
  const auto& received = journal.received.events;
  if (received.empty()) {
    for (const CallRecord& call : journal.calls) event(call);
    event(Process::Orchestrator, Kind::Step, journal.step);
  } else {
    for (std::size_t i = 0; i < journal.calls.size(); ++i) {
      event(topic_of(journal.calls[i].side), Kind::Call, received[i]);
    }
    event(Process::Orchestrator, Kind::Step, received.back());
  }
  flush();
}

void LogWriter::write(const Finished& finished) {
  event(Process::Orchestrator, Kind::Finished, finished);
  flush();
}

LogReader::LogReader(const std::filesystem::path& file)
    : name_(file.string()), file_(file, std::ios::binary | std::ios::ate) {
  require(file_.is_open(), fmt::format("log: cannot read {}: {}", name_, std::strerror(errno)));
  size_ = static_cast<std::int64_t>(file_.tellg());
  file_.seekg(0);
  const auto first = next_raw();
  const auto scenario = first ? decode_scenario(first->payload) : std::nullopt;
  require(scenario.has_value(),
          fmt::format("log: {} is not an exchange log: its first event is not a scenario", name_));
  scenario_ = *scenario;
  run_id_ = first->header.run_id;
}

void LogReader::fail(const std::string& what) const {
  const std::string where = at_end_ ? fmt::format("its last one, behind macro step {}", macro_step_)
                                    : fmt::format("in macro step {}", macro_step_ + 1);
  throw Error(ErrorKind::Usage,
              fmt::format("log: {} is damaged at event {} ({}): {}", name_, number_, where, what));
}

bool LogReader::another_event_follows() {
  std::array<char, 12> next{};
  for (std::size_t i = 0; i < 4; ++i) next[i] = static_cast<char>(kMagic >> (24U - 8U * i));
  const auto number = static_cast<std::uint64_t>(number_ + 1);
  for (std::size_t i = 0; i < 8; ++i) next[4 + i] = static_cast<char>(number >> (56U - 8U * i));
  const std::string rest{std::istreambuf_iterator<char>(file_), {}};
  return rest.find(std::string_view(next.data(), next.size())) != std::string::npos;
}

std::optional<LogReader::RawEvent> LogReader::next_raw() {
  std::array<std::uint8_t, kEventHeader> head{};
  const std::int64_t rest = size_ - static_cast<std::int64_t>(file_.tellg());
  if (rest < static_cast<std::int64_t>(kEventHeader)) return std::nullopt;
  file_.read(reinterpret_cast<char*>(head.data()), kEventHeader);
  const auto channel_size = static_cast<std::int32_t>(big_endian(head.data() + 20, 4));
  const auto payload_size = static_cast<std::int32_t>(big_endian(head.data() + 24, 4));
  at_end_ = std::int64_t{channel_size} + payload_size == rest - std::int64_t{kEventHeader};
  if (big_endian(head.data(), 4) != kMagic) fail("its sync word is wrong");
  if (static_cast<std::int64_t>(big_endian(head.data() + 4, 8)) != number_) {
    fail("its number is not the next one");
  }
  if (channel_size < 1 || channel_size > kMaxChannel || payload_size < 0 ||
      payload_size > kMaxPayload) {
    fail("its lengths are out of range");
  }
  if (channel_size + payload_size > rest - static_cast<std::int64_t>(kEventHeader)) {
    if (another_event_follows()) fail("its lengths are out of range");
    return std::nullopt;  // cut short: the run was killed while it wrote
  }
  RawEvent event;
  event.time_us = static_cast<std::int64_t>(big_endian(head.data() + 12, 8));
  event.channel.resize(static_cast<std::size_t>(channel_size));
  event.payload.resize(static_cast<std::size_t>(payload_size));
  file_.read(event.channel.data(), channel_size);
  file_.read(reinterpret_cast<char*>(event.payload.data()), payload_size);
  if (!file_) fail("it cannot be read");
  const auto header = open_seal(event.payload);
  if (!header) fail("its checksum is wrong");
  if (header->sequence != number_ || header->time_us != event.time_us ||
      (number_ > 0 && header->run_id != run_id_) ||
      channel_of(*header, event.payload) != event.channel) {
    fail("its header does not fit its content");
  }
  event.header = *header;
  ++number_;
  return event;
}

std::optional<LogReader::Event> LogReader::next() {
  const auto raw = next_raw();
  if (!raw) return std::nullopt;
  std::optional<Event> event;
  if (raw->header.kind == Kind::Call) {
    if (auto call = decode_call(raw->payload)) {
      accepted_.complete(*call);
      accepted_.follow(*call);
      event = std::move(*call);
    }
  } else if (raw->header.kind == Kind::Step) {
    if (auto step = decode_step(raw->payload)) event = std::move(*step);
  } else if (raw->header.kind == Kind::Finished) {
    finished_ = decode_finished(raw->payload);
    if (finished_) event = *finished_;
  }
  if (!event) fail("its content is of another version of Tandem");
  if (raw->header.kind == Kind::Step) macro_step_ = raw->header.macro_step;
  return event;
}

std::optional<StepJournal> LogReader::next_step() {
  StepJournal journal;
  while (auto event = next()) {
    if (auto* call = std::get_if<CallRecord>(&*event)) {
      journal.calls.push_back(std::move(*call));
    } else if (auto* step = std::get_if<StepRecord>(&*event)) {
      journal.step = *step;
      return journal;
    } else {
      return std::nullopt;  // finished
    }
  }
  return std::nullopt;
}

}  // namespace tandem::wire
