#include <algorithm>
#include <tandem_wire/call_of_7_t.hpp>
#include <tandem_wire/call_t.hpp>
#include <tandem_wire/finished_t.hpp>
#include <tandem_wire/journal_t.hpp>
#include <tandem_wire/scenario_t.hpp>
#include <tandem_wire/step_t.hpp>
#include <utility>

#include "protocol/wire/codec.h"
#include "protocol/wire/messages.h"

namespace tandem::wire {

using codec::arrays_of;
using codec::count;
using codec::count_at;
using codec::from_bytes;
using codec::pack;
using codec::to_bytes;
using codec::unpack;

namespace {

constexpr std::size_t kSizeBytes = 4;

// A call's times as numbers: two of the call, and so many of each part.
constexpr std::size_t kCallNumbers = 2, kPartNumbers = 7;

std::vector<double> pack(const CallTimes& times) {
  if (times.end_s == 0.0) return {};
  std::vector<double> numbers{times.begin_s, times.end_s};
  numbers.reserve(kCallNumbers + kPartNumbers * times.parts.size());
  for (const PartTimes& part : times.parts) {
    numbers.insert(numbers.end(), {part.sent_s, part.awaited_s, part.arrived_s, part.side_us,
                                   part.compute_s, part.decode_s, part.encode_s});
  }
  return numbers;
}

CallTimes unpack_times(std::span<const double> numbers) {
  CallTimes times;
  if (numbers.size() < kCallNumbers) return times;
  times.begin_s = numbers[0];
  times.end_s = numbers[1];
  for (auto rest = numbers.subspan(kCallNumbers); rest.size() >= kPartNumbers;
       rest = rest.subspan(kPartNumbers)) {
    times.parts.push_back({.sent_s = rest[0],
                           .awaited_s = rest[1],
                           .arrived_s = rest[2],
                           .side_us = rest[3],
                           .compute_s = rest[4],
                           .decode_s = rest[5],
                           .encode_s = rest[6]});
  }
  return times;
}

void append(const Header& header, const CallRecord& call, Bytes& to, bool without_begin = false) {
  tandem_wire::call_t fixed{};
  fixed.header = pack(header);
  fixed.header.macro_step = call.macro_step;
  fixed.header.iteration = call.iteration;
  fixed.side = static_cast<std::int32_t>(call.side);
  fixed.call = static_cast<std::int32_t>(call.kind);
  fixed.checkpoint_first = call.checkpoint_first;
  fixed.rollback_first = call.rollback_first;
  fixed.linearize = call.linearize;
  fixed.accepted = call.accepted;
  fixed.step_ns = call.step.count();
  fixed.outcome = static_cast<std::int32_t>(call.outcome);
  fixed.solver_iterations = call.solver_iterations;
  const bool from_mbs = call.side == SideName::Mbs;
  std::span<const Motion> motions_begin = call.motions.begin;
  std::span<const Wrench> wrenches_begin = call.wrenches.begin;
  if (without_begin && from_mbs) wrenches_begin = {};
  if (without_begin && !from_mbs) motions_begin = {};
  const std::vector<double> times = pack(call.times);
  codec::begin(fixed,
               {{motions_begin.size(), kMotionBytes},
                {call.motions.end.size(), kMotionBytes},
                {wrenches_begin.size(), kWrenchBytes},
                {call.wrenches.end.size(), kWrenchBytes},
                {call.message.size(), 1},
                {call.command.size(), 1},
                {times.size(), 8}},
               to, to.size())
      .add(motions_begin)
      .add(call.motions.end)
      .add(wrenches_begin)
      .add(call.wrenches.end)
      .add(std::span<const char>(call.message))
      .add(std::span<const char>(call.command))
      .add(std::span<const double>(times));
}

}  // namespace

void encode(const Header& header, const CallRecord& call, Bytes& message, bool without_begin) {
  message.clear();
  append(header, call, message, without_begin);
}

namespace {

template <class Call>
std::optional<Call> fixed_part_of_call(ByteView message,
                                       std::initializer_list<std::size_t> element_bytes) {
  auto fixed = codec::fixed_part<Call>(message, element_bytes);
  if (!fixed || fixed->side < 0 || fixed->side > 1 || fixed->call < 0 ||
      fixed->call > static_cast<int>(CallKind::Command) || fixed->outcome < 0 ||
      fixed->outcome > static_cast<int>(Outcome::Failed)) {
    return std::nullopt;
  }
  return fixed;
}

std::optional<tandem_wire::call_t> head_of_call(ByteView message) {
  return fixed_part_of_call<tandem_wire::call_t>(
      message, {kMotionBytes, kMotionBytes, kWrenchBytes, kWrenchBytes, 1, 1, 8});
}
std::optional<tandem_wire::call_of_7_t> head_of_call_of_7(ByteView message) {
  return fixed_part_of_call<tandem_wire::call_of_7_t>(
      message, {kMotionBytes, kMotionBytes, kWrenchBytes, kWrenchBytes, 1, 1});
}

/// All of a call but its times; `values` goes on to what stands behind the last array.
template <class Call>
CallRecord read_call(ByteView message, const Call& fixed, ArrayReader& values) {
  CallRecord call;
  call.side = static_cast<SideName>(fixed.side);
  call.kind = static_cast<CallKind>(fixed.call);
  call.checkpoint_first = fixed.checkpoint_first != 0;
  call.rollback_first = fixed.rollback_first != 0;
  call.linearize = fixed.linearize != 0;
  call.accepted = fixed.accepted != 0;
  call.macro_step = fixed.header.macro_step;
  call.iteration = fixed.header.iteration;
  call.step = SimTime(fixed.step_ns);
  call.outcome = static_cast<Outcome>(fixed.outcome);
  call.solver_iterations = fixed.solver_iterations;
  values.take(count_at(message, 0), call.motions.begin)
      .take(count_at(message, 1), call.motions.end)
      .take(count_at(message, 2), call.wrenches.begin)
      .take(count_at(message, 3), call.wrenches.end)
      .take(count_at(message, 4), call.message)
      .take(count_at(message, 5), call.command);
  return call;
}

}  // namespace

std::optional<SideName> side_of_call(ByteView message) {
  if (const auto fixed = head_of_call(message)) return static_cast<SideName>(fixed->side);
  if (const auto fixed = head_of_call_of_7(message)) return static_cast<SideName>(fixed->side);
  return std::nullopt;
}

std::optional<CallRecord> decode_call(ByteView message) {
  if (const auto fixed = head_of_call(message)) {
    ArrayReader values = arrays_of(message, *fixed);
    CallRecord call = read_call(message, *fixed, values);
    std::vector<double> times(count_at(message, 6));
    values.take(std::span<double>(times));
    call.times = unpack_times(times);
    return call;
  }
  const auto fixed = head_of_call_of_7(message);
  if (!fixed) return std::nullopt;
  ArrayReader values = arrays_of(message, *fixed);
  return read_call(message, *fixed, values);
}

namespace {

std::vector<double> pack(const SideEnergies& energy) {
  std::vector<double> values;
  const auto add = [&](const EnergyBook& book) {
    values.insert(values.end(),
                  {book.kinetic_J, book.potential_J, book.elastic_J, book.external_work_J,
                   book.interface_work_J, book.damping_loss_J, book.numerical_loss_J});
  };
  add(energy.mbs);
  add(energy.fem);
  for (const EnergyBook& part : energy.parts) add(part);
  return values;
}

constexpr std::size_t kBookEntries = 7;

EnergyBook unpack_book(std::span<const double, kBookEntries> v) {
  return {.kinetic_J = v[0],
          .potential_J = v[1],
          .elastic_J = v[2],
          .external_work_J = v[3],
          .interface_work_J = v[4],
          .damping_loss_J = v[5],
          .numerical_loss_J = v[6]};
}

}  // namespace

Bytes encode(const Header& header, const StepRecord& step) {
  tandem_wire::step_t packed;
  packed.header = pack(header);
  packed.header.macro_step = step.macro_step;
  packed.header.iteration = step.iterations;
  packed.time_ns = step.time.count();
  packed.step_ns = step.step.count();
  packed.iterations = step.iterations;
  packed.outcome = static_cast<std::int32_t>(step.outcome);
  packed.residual_N = step.residual_N;
  packed.energy_defect_J = step.energy_defect_J;
  const Ledger& ledger = step.ledger;
  packed.mbs_compute_s = ledger.mbs_compute_s;
  packed.fem_compute_s = ledger.fem_compute_s;
  packed.encode_s = ledger.encode_s;
  packed.decode_s = ledger.decode_s;
  packed.publish_s = ledger.publish_s;
  packed.transit_s = ledger.transit_s;
  packed.wait_s = ledger.wait_s;
  packed.scheme_s = ledger.scheme_s;
  packed.record_s = ledger.record_s;
  packed.other_s = ledger.other_s;
  packed.overlap_s = ledger.overlap_s;
  packed.discarded_s = ledger.discarded_s;
  packed.messages = ledger.messages;
  packed.bytes = ledger.bytes;
  packed.resent = ledger.resent;
  packed.duplicates = ledger.duplicates;
  packed.lost = ledger.lost;
  if (step.energy) packed.energy_J = pack(*step.energy);
  packed.n_energy = count(packed.energy_J);
  return to_bytes(packed);
}

std::optional<StepRecord> decode_step(ByteView message) {
  const auto packed = from_bytes(message, tandem_wire::step_t{}, {8});
  if (!packed || packed->energy_J.size() % kBookEntries != 0 ||
      packed->energy_J.size() == kBookEntries || packed->outcome < 0 ||
      packed->outcome > static_cast<int>(Outcome::Failed)) {
    return std::nullopt;
  }
  StepRecord step;
  step.macro_step = packed->header.macro_step;
  step.time = SimTime(packed->time_ns);
  step.step = SimTime(packed->step_ns);
  step.iterations = packed->iterations;
  step.outcome = static_cast<Outcome>(packed->outcome);
  step.residual_N = packed->residual_N;
  step.energy_defect_J = packed->energy_defect_J;
  step.ledger = {.mbs_compute_s = packed->mbs_compute_s,
                 .fem_compute_s = packed->fem_compute_s,
                 .encode_s = packed->encode_s,
                 .decode_s = packed->decode_s,
                 .publish_s = packed->publish_s,
                 .transit_s = packed->transit_s,
                 .wait_s = packed->wait_s,
                 .scheme_s = packed->scheme_s,
                 .record_s = packed->record_s,
                 .other_s = packed->other_s,
                 .overlap_s = packed->overlap_s,
                 .discarded_s = packed->discarded_s,
                 .messages = packed->messages,
                 .bytes = packed->bytes,
                 .resent = packed->resent,
                 .duplicates = packed->duplicates,
                 .lost = packed->lost};
  if (packed->n_energy > 0) {
    const std::span<const double> values(packed->energy_J);
    step.energy = {.mbs = unpack_book(values.first<kBookEntries>()),
                   .fem = unpack_book(values.subspan<kBookEntries, kBookEntries>())};
    for (std::size_t at = 2 * kBookEntries; at < values.size(); at += kBookEntries) {
      step.energy->parts.push_back(unpack_book(values.subspan(at).first<kBookEntries>()));
    }
  }
  return step;
}

namespace {

/// Appends one event behind its size.
template <class Write>
void append_sized(Bytes& message, Write write) {
  const std::size_t at = message.size();
  message.resize(at + kSizeBytes);
  write();
  codec::write_word(message.size() - at - kSizeBytes, message.data() + at);
}

}  // namespace

namespace {

/// So that a step of many ports does not have its first calls moved for each of the later ones.
void make_room(const StepJournal& journal, Bytes& message) {
  std::size_t size = message.size();
  for (const CallRecord& call : journal.calls) {
    constexpr std::size_t kFixed = 256;  // more than the fixed part and the size of a call
    size += kFixed + (call.motions.begin.size() + call.motions.end.size()) * kMotionBytes +
            (call.wrenches.begin.size() + call.wrenches.end.size()) * kWrenchBytes +
            (kCallNumbers + kPartNumbers * call.times.parts.size()) * 8;
  }
  if (size > message.capacity()) message.reserve(std::max(size, 2 * message.capacity()));
}

void append(const StepRecord& step, Bytes& message) {
  const Bytes encoded = encode(Header{}, step);
  message.insert(message.end(), encoded.begin(), encoded.end());
}

}  // namespace

void begin_journal(Bytes& message) { codec::begin(tandem_wire::journal_t{}, {{0, 1}}, message); }

void append(const StepJournal& journal, Bytes& message) {
  make_room(journal, message);
  for (const CallRecord& call : journal.calls) {
    append_sized(message, [&] { append(Header{}, call, message); });
  }
  append_sized(message, [&] { append(journal.step, message); });
}

void append(StepJournal&& journal, AcceptedInputs& accepted, Bytes& message) {
  make_room(journal, message);
  for (CallRecord& call : journal.calls) {
    const bool known = accepted.is_begin_of(call);
    append_sized(message, [&] { append(Header{}, call, message, known); });
    accepted.follow(std::move(call));
  }
  append_sized(message, [&] { append(journal.step, message); });
}

void end_journal(const Header& header, Bytes& message) {
  tandem_wire::journal_t fixed{};
  fixed.header = pack(header);
  const auto fixed_bytes = static_cast<std::size_t>(fixed.getEncodedSize());
  fixed.encode(message.data(), 0, static_cast<int>(fixed_bytes));
  codec::write_counts({{message.size() - fixed_bytes, 1}}, message.data());
}

std::optional<std::vector<StepJournal>> decode_journal(ByteView message) {
  const auto fixed = codec::fixed_part<tandem_wire::journal_t>(message, {1});
  if (!fixed) return std::nullopt;
  std::vector<StepJournal> journals;
  StepJournal open;
  ByteView rest = message.last(count_at(message, 0));
  while (rest.size() >= kSizeBytes) {
    const std::size_t size = codec::read_word(rest.data());
    rest = rest.subspan(kSizeBytes);
    if (size > rest.size()) return std::nullopt;
    const ByteView event = rest.first(size);
    rest = rest.subspan(size);
    if (auto call = decode_call(event)) {
      open.calls.push_back(std::move(*call));
    } else if (const auto step = decode_step(event)) {
      open.step = *step;
      journals.push_back(std::exchange(open, {}));
    } else {
      return std::nullopt;
    }
  }
  if (!rest.empty() || !open.calls.empty() || journals.empty()) return std::nullopt;
  return journals;
}

std::optional<std::vector<StepJournal>> decode_journal(const std::shared_ptr<Bytes>& message) {
  auto journals = decode_journal(ByteView(*message));
  if (!journals) return std::nullopt;
  std::span<std::uint8_t> rest = std::span(*message).last(count_at(*message, 0));
  for (StepJournal& journal : *journals) {
    journal.received.message = message;
    for (std::size_t event = 0; event <= journal.calls.size(); ++event) {
      const std::size_t size = codec::read_word(rest.data());
      journal.received.events.push_back(rest.subspan(kSizeBytes, size));
      rest = rest.subspan(kSizeBytes + size);
    }
  }
  return journals;
}

Bytes encode(const Header& header, const Finished& finished) {
  tandem_wire::finished_t packed;
  packed.header = pack(header);
  packed.exit_code = finished.exit_code;
  packed.message = pack(finished.message);
  packed.summary_json = pack(finished.summary_json);
  packed.n_message = count(packed.message);
  packed.n_summary_json = count(packed.summary_json);
  return to_bytes(packed);
}

std::optional<Finished> decode_finished(ByteView message) {
  const auto packed = from_bytes(message, tandem_wire::finished_t{}, {1, 1});
  if (!packed) return std::nullopt;
  return Finished{packed->exit_code, unpack(packed->message), unpack(packed->summary_json)};
}

Bytes encode(const Header& header, const ScenarioText& scenario) {
  tandem_wire::scenario_t packed;
  packed.header = pack(header);
  packed.scenario_yaml = pack(scenario.scenario_yaml);
  packed.versions = pack(scenario.versions);
  packed.n_scenario_yaml = count(packed.scenario_yaml);
  packed.n_versions = count(packed.versions);
  return to_bytes(packed);
}

std::optional<ScenarioText> decode_scenario(ByteView message) {
  const auto packed = from_bytes(message, tandem_wire::scenario_t{}, {1, 1});
  if (!packed) return std::nullopt;
  return ScenarioText{unpack(packed->scenario_yaml), unpack(packed->versions)};
}

}  // namespace tandem::wire
