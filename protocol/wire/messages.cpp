#include "protocol/wire/messages.h"

#include <sstream>
#include <tandem_wire/abort_t.hpp>
#include <tandem_wire/alive_t.hpp>
#include <tandem_wire/chunk_t.hpp>
#include <tandem_wire/credit_t.hpp>
#include <tandem_wire/handshake_t.hpp>
#include <tandem_wire/reply_t.hpp>
#include <tandem_wire/request_t.hpp>

#include "protocol/wire/codec.h"

namespace tandem::wire {

using codec::count;
using codec::from_bytes;
using codec::kMotionBytes;
using codec::kWrenchBytes;
using codec::pack;
using codec::to_bytes;
using codec::unpack;

Bytes encode(const Request& request) {
  tandem_wire::request_t packed;
  packed.header = pack(request.header);
  packed.n_motions_begin = count(request.motions.begin);
  packed.n_motions_end = count(request.motions.end);
  packed.n_wrenches_begin = count(request.wrenches.begin);
  packed.n_wrenches_end = count(request.wrenches.end);
  packed.call = static_cast<std::int32_t>(request.call);
  packed.checkpoint_first = request.checkpoint_first;
  packed.rollback_first = request.rollback_first;
  packed.linearize = request.linearize;
  packed.step_ns = request.step.count();
  packed.motions_begin = pack(request.motions.begin);
  packed.motions_end = pack(request.motions.end);
  packed.wrenches_begin = pack(request.wrenches.begin);
  packed.wrenches_end = pack(request.wrenches.end);
  return to_bytes(packed);
}

std::optional<Request> decode_request(ByteView message) {
  const auto packed = from_bytes(message, tandem_wire::request_t{},
                                 {kMotionBytes, kMotionBytes, kWrenchBytes, kWrenchBytes});
  if (!packed || packed->call < 0 || packed->call > static_cast<int>(RequestKind::Bye)) {
    return std::nullopt;
  }
  Request request;
  request.header = unpack(packed->header);
  request.call = static_cast<RequestKind>(packed->call);
  request.checkpoint_first = packed->checkpoint_first != 0;
  request.rollback_first = packed->rollback_first != 0;
  request.linearize = packed->linearize != 0;
  request.step = SimTime(packed->step_ns);
  request.motions = {unpack(packed->motions_begin), unpack(packed->motions_end)};
  request.wrenches = {unpack(packed->wrenches_begin), unpack(packed->wrenches_end)};
  return request;
}

Bytes encode(const Reply& reply) {
  tandem_wire::reply_t packed;
  packed.header = pack(reply.header);
  packed.compute_s = reply.cost.compute_s;
  packed.decode_s = reply.cost.decode_s;
  packed.encode_s = reply.cost.encode_s;
  packed.publish_s = reply.cost.publish_s;
  packed.duplicates = reply.duplicates;
  packed.outcome = static_cast<std::int32_t>(reply.outcome);
  packed.error_kind = reply.error ? static_cast<std::int32_t>(*reply.error) : -1;
  packed.solver_iterations = reply.solver_iterations;
  packed.jacobian_rows = -1;
  if (reply.jacobian) {
    packed.jacobian_rows = static_cast<std::int32_t>(reply.jacobian->rows());
    packed.jacobian.assign(reply.jacobian->data(), reply.jacobian->data() + reply.jacobian->size());
  }
  packed.time_ns = reply.observation.time.count();
  packed.kinetic_J = reply.observation.energy.kinetic_J;
  packed.potential_J = reply.observation.energy.potential_J;
  packed.elastic_J = reply.observation.energy.elastic_J;
  packed.external_work_J = reply.observation.energy.external_work_J;
  packed.state_hash = static_cast<std::int64_t>(reply.observation.state_hash);
  packed.motions = pack(reply.motions);
  packed.wrenches = pack(reply.wrenches);
  packed.message = pack(reply.message);
  packed.n_motions = count(packed.motions);
  packed.n_wrenches = count(packed.wrenches);
  packed.n_jacobian = count(packed.jacobian);
  packed.n_message = count(packed.message);
  return to_bytes(packed);
}

namespace {

// False when rows do not divide the number of entries.
bool unpack_jacobian(const tandem_wire::reply_t& packed, Reply& reply) {
  if (packed.jacobian_rows < 0) return packed.n_jacobian == 0;
  const Eigen::Index rows = packed.jacobian_rows;
  const Eigen::Index columns = rows == 0 ? 0 : packed.n_jacobian / rows;
  if (rows * columns != packed.n_jacobian) return false;
  reply.jacobian = Eigen::Map<const Eigen::MatrixXd>(packed.jacobian.data(), rows, columns);
  return true;
}

}  // namespace

std::optional<Reply> decode_reply(ByteView message) {
  const auto packed =
      from_bytes(message, tandem_wire::reply_t{}, {kMotionBytes, kWrenchBytes, 8, 1});
  if (!packed || packed->outcome < 0 || packed->outcome > static_cast<int>(Outcome::Failed) ||
      packed->error_kind < -1 || packed->error_kind > static_cast<int>(ErrorKind::ReplayDiffers)) {
    return std::nullopt;
  }
  Reply reply;
  if (!unpack_jacobian(*packed, reply)) return std::nullopt;
  reply.header = unpack(packed->header);
  reply.cost = {packed->compute_s, packed->decode_s, packed->encode_s, packed->publish_s};
  reply.duplicates = packed->duplicates;
  reply.outcome = static_cast<Outcome>(packed->outcome);
  if (packed->error_kind >= 0) reply.error = static_cast<ErrorKind>(packed->error_kind);
  reply.message = unpack(packed->message);
  reply.solver_iterations = packed->solver_iterations;
  reply.observation.time = SimTime(packed->time_ns);
  reply.observation.energy = {packed->kinetic_J, packed->potential_J, packed->elastic_J,
                              packed->external_work_J};
  reply.observation.state_hash = static_cast<std::uint64_t>(packed->state_hash);
  reply.motions = unpack(packed->motions);
  reply.wrenches = unpack(packed->wrenches);
  return reply;
}

Bytes encode(const Handshake& handshake) {
  tandem_wire::handshake_t packed;
  packed.header = pack(handshake.header);
  packed.protocol_version = handshake.protocol_version;
  packed.scenario_hash = static_cast<std::int64_t>(handshake.scenario_hash);
  packed.micro_step_ns = handshake.micro_step.count();
  packed.can_linearize = handshake.can_linearize;
  packed.receive_buffer_bytes = handshake.receive_buffer_bytes;
  packed.process_id = handshake.process_id;
  std::string names;
  for (const PortInfo& port : handshake.ports) {
    names += port.name + "\n";
    packed.port_length_m.push_back(port.length_m);
  }
  packed.tandem_version = pack(handshake.tandem_version);
  packed.port_names = pack(names);
  packed.refusal = pack(handshake.refusal);
  packed.n_tandem_version = count(packed.tandem_version);
  packed.n_port_names = count(packed.port_names);
  packed.n_ports = count(packed.port_length_m);
  packed.n_refusal = count(packed.refusal);
  return to_bytes(packed);
}

std::optional<Handshake> decode_handshake(ByteView message) {
  const auto packed = from_bytes(message, tandem_wire::handshake_t{}, {1, 1, 8, 1});
  if (!packed) return std::nullopt;
  Handshake handshake;
  handshake.header = unpack(packed->header);
  handshake.protocol_version = packed->protocol_version;
  handshake.tandem_version = unpack(packed->tandem_version);
  handshake.scenario_hash = static_cast<std::uint64_t>(packed->scenario_hash);
  std::istringstream names(unpack(packed->port_names));
  for (const double length_m : packed->port_length_m) {
    PortInfo port{.name = {}, .length_m = length_m};
    if (!std::getline(names, port.name)) return std::nullopt;
    handshake.ports.push_back(port);
  }
  handshake.micro_step = SimTime(packed->micro_step_ns);
  handshake.can_linearize = packed->can_linearize != 0;
  handshake.receive_buffer_bytes = packed->receive_buffer_bytes;
  handshake.process_id = packed->process_id;
  handshake.refusal = unpack(packed->refusal);
  return handshake;
}

Bytes encode(const Alive& alive) {
  tandem_wire::alive_t packed;
  packed.header = pack(alive.header);
  packed.process_id = alive.process_id;
  packed.phase = pack(alive.phase);
  packed.n_phase = count(packed.phase);
  return to_bytes(packed);
}

std::optional<Alive> decode_alive(ByteView message) {
  const auto packed = from_bytes(message, tandem_wire::alive_t{}, {1});
  if (!packed) return std::nullopt;
  return Alive{unpack(packed->header), packed->process_id, unpack(packed->phase)};
}

Bytes encode(const Abort& abort) {
  tandem_wire::abort_t packed;
  packed.header = pack(abort.header);
  packed.exit_code = abort.exit_code;
  packed.text = pack(abort.text);
  packed.n_text = count(packed.text);
  return to_bytes(packed);
}

std::optional<Abort> decode_abort(ByteView message) {
  const auto packed = from_bytes(message, tandem_wire::abort_t{}, {1});
  if (!packed) return std::nullopt;
  return Abort{unpack(packed->header), packed->exit_code, unpack(packed->text)};
}

Bytes encode(const Credit& credit) {
  tandem_wire::credit_t packed;
  packed.header = pack(credit.header);
  packed.recorded_through = credit.recorded_through;
  packed.wanted = credit.wanted;
  return to_bytes(packed);
}

std::optional<Credit> decode_credit(ByteView message) {
  const auto packed = from_bytes(message, tandem_wire::credit_t{}, {});
  if (!packed) return std::nullopt;
  return Credit{unpack(packed->header), packed->recorded_through, packed->wanted};
}

Bytes encode(const Chunk& chunk) {
  tandem_wire::chunk_t packed;
  packed.header = pack(chunk.header);
  packed.whole_kind = static_cast<std::int32_t>(chunk.whole_kind);
  packed.whole_checksum = static_cast<std::int32_t>(chunk.whole_checksum);
  packed.whole_bytes = chunk.whole_bytes;
  packed.index = chunk.index;
  packed.count = chunk.count;
  packed.bytes = chunk.bytes;
  packed.n_bytes = count(packed.bytes);
  return to_bytes(packed);
}

std::optional<Chunk> decode_chunk(ByteView message) {
  auto packed = from_bytes(message, tandem_wire::chunk_t{}, {1});
  if (!packed) return std::nullopt;
  Chunk chunk;
  chunk.header = unpack(packed->header);
  chunk.whole_kind = static_cast<Kind>(packed->whole_kind);
  chunk.whole_checksum = static_cast<std::uint32_t>(packed->whole_checksum);
  chunk.whole_bytes = packed->whole_bytes;
  chunk.index = packed->index;
  chunk.count = packed->count;
  chunk.bytes = std::move(packed->bytes);
  return chunk;
}

}  // namespace tandem::wire
