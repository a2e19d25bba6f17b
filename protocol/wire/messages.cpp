#include "protocol/wire/messages.h"

#include <sstream>
#include <tandem_wire/abort_t.hpp>
#include <tandem_wire/alive_t.hpp>
#include <tandem_wire/credit_t.hpp>
#include <tandem_wire/handshake_t.hpp>
#include <tandem_wire/reply_t.hpp>
#include <tandem_wire/request_t.hpp>

#include "protocol/wire/codec.h"

namespace tandem::wire {

using codec::arrays_of;
using codec::count;
using codec::count_at;
using codec::from_bytes;
using codec::pack;
using codec::to_bytes;
using codec::unpack;

void encode(const RequestView& request, Bytes& message) {
  tandem_wire::request_t fixed{};
  fixed.header = pack(request.head.header);
  fixed.call = static_cast<std::int32_t>(request.head.call);
  fixed.checkpoint_first = request.head.checkpoint_first;
  fixed.rollback_first = request.head.rollback_first;
  fixed.linearize = request.head.linearize;
  fixed.step_ns = request.head.step.count();
  codec::begin(fixed,
               {{request.motions_begin.size(), kMotionBytes},
                {request.motions_end.size(), kMotionBytes},
                {request.wrenches_begin.size(), kWrenchBytes},
                {request.wrenches_end.size(), kWrenchBytes},
                {request.head.command.size(), 1}},
               message)
      .add(request.motions_begin)
      .add(request.motions_end)
      .add(request.wrenches_begin)
      .add(request.wrenches_end)
      .add(std::span<const char>(request.head.command));
}

Bytes encode(const Request& request) {
  Bytes message;
  Request head = request;
  encode({head, request.motions.begin, request.motions.end, request.wrenches.begin,
          request.wrenches.end},
         message);
  return message;
}

bool decode(ByteView message, Request& request) {
  const auto fixed = codec::fixed_part<tandem_wire::request_t>(
      message, {kMotionBytes, kMotionBytes, kWrenchBytes, kWrenchBytes, 1});
  if (!fixed || fixed->call < 0 || fixed->call > static_cast<int>(RequestKind::Command)) {
    return false;
  }
  request.header = unpack(fixed->header);
  request.call = static_cast<RequestKind>(fixed->call);
  request.checkpoint_first = fixed->checkpoint_first != 0;
  request.rollback_first = fixed->rollback_first != 0;
  request.linearize = fixed->linearize != 0;
  request.step = SimTime(fixed->step_ns);
  arrays_of(message, *fixed)
      .take(count_at(message, 0), request.motions.begin)
      .take(count_at(message, 1), request.motions.end)
      .take(count_at(message, 2), request.wrenches.begin)
      .take(count_at(message, 3), request.wrenches.end)
      .take(count_at(message, 4), request.command);
  return true;
}

std::optional<Request> decode_request(ByteView message) {
  Request request;
  if (!decode(message, request)) return std::nullopt;
  return request;
}

void encode(const Reply& reply, Bytes& message) {
  tandem_wire::reply_t fixed{};
  fixed.header = pack(reply.header);
  fixed.compute_s = reply.cost.compute_s;
  fixed.decode_s = reply.cost.decode_s;
  fixed.encode_s = reply.cost.encode_s;
  fixed.publish_s = reply.cost.publish_s;
  fixed.duplicates = reply.duplicates;
  fixed.outcome = static_cast<std::int32_t>(reply.outcome);
  fixed.error_kind = reply.error ? static_cast<std::int32_t>(*reply.error) : -1;
  fixed.solver_iterations = reply.solver_iterations;
  fixed.output_error_N = reply.output_error_N;
  fixed.jacobian_rows = -1;
  std::span<const double> jacobian;
  if (reply.jacobian) {
    fixed.jacobian_rows = static_cast<std::int32_t>(reply.jacobian->rows());
    jacobian = {reply.jacobian->data(), static_cast<std::size_t>(reply.jacobian->size())};
  }
  fixed.time_ns = reply.observation.time.count();
  fixed.kinetic_J = reply.observation.energy.kinetic_J;
  fixed.potential_J = reply.observation.energy.potential_J;
  fixed.elastic_J = reply.observation.energy.elastic_J;
  fixed.external_work_J = reply.observation.energy.external_work_J;
  fixed.interface_work_J = reply.observation.energy.interface_work_J;
  fixed.damping_loss_J = reply.observation.energy.damping_loss_J;
  fixed.numerical_loss_J = reply.observation.energy.numerical_loss_J;
  fixed.state_hash = static_cast<std::int64_t>(reply.observation.state_hash);
  fixed.elastic_turn_rad = reply.observation.elastic_turn_rad;
  fixed.joint_gap_m = reply.observation.widest_joint.gap_m;
  fixed.joint_gap_part = reply.observation.widest_joint.part;
  fixed.gap_joint = reply.observation.widest_joint.joint;
  codec::begin(fixed,
               {{reply.motions.size(), kMotionBytes},
                {reply.wrenches.size(), kWrenchBytes},
                {jacobian.size(), 8},
                {reply.message.size(), 1}},
               message)
      .add(reply.motions)
      .add(reply.wrenches)
      .add(jacobian)
      .add(std::span<const char>(reply.message));
}

Bytes encode(const Reply& reply) {
  Bytes message;
  encode(reply, message);
  return message;
}

namespace {

// False when rows do not divide the number of entries.
bool shape_jacobian(std::int32_t rows_sent, std::size_t entries, Reply& reply) {
  reply.jacobian.reset();
  if (rows_sent < 0) return entries == 0;
  const Eigen::Index rows = rows_sent;
  const Eigen::Index columns = rows == 0 ? 0 : static_cast<Eigen::Index>(entries) / rows;
  if (rows * columns != static_cast<Eigen::Index>(entries)) return false;
  reply.jacobian.emplace(rows, columns);
  return true;
}

}  // namespace

bool decode(ByteView message, Reply& reply) {
  const auto fixed =
      codec::fixed_part<tandem_wire::reply_t>(message, {kMotionBytes, kWrenchBytes, 8, 1});
  if (!fixed || fixed->outcome < 0 || fixed->outcome > static_cast<int>(Outcome::Failed) ||
      fixed->error_kind < -1 || fixed->error_kind > static_cast<int>(ErrorKind::ReplayDiffers) ||
      !shape_jacobian(fixed->jacobian_rows, count_at(message, 2), reply)) {
    return false;
  }
  reply.header = unpack(fixed->header);
  reply.cost = {fixed->compute_s, fixed->decode_s, fixed->encode_s, fixed->publish_s};
  reply.duplicates = fixed->duplicates;
  reply.outcome = static_cast<Outcome>(fixed->outcome);
  reply.error.reset();
  if (fixed->error_kind >= 0) reply.error = static_cast<ErrorKind>(fixed->error_kind);
  reply.solver_iterations = fixed->solver_iterations;
  reply.output_error_N = fixed->output_error_N;
  reply.observation.time = SimTime(fixed->time_ns);
  reply.observation.energy = {.kinetic_J = fixed->kinetic_J,
                              .potential_J = fixed->potential_J,
                              .elastic_J = fixed->elastic_J,
                              .external_work_J = fixed->external_work_J,
                              .interface_work_J = fixed->interface_work_J,
                              .damping_loss_J = fixed->damping_loss_J,
                              .numerical_loss_J = fixed->numerical_loss_J};
  reply.observation.state_hash = static_cast<std::uint64_t>(fixed->state_hash);
  reply.observation.elastic_turn_rad = fixed->elastic_turn_rad;
  reply.observation.widest_joint = {.gap_m = fixed->joint_gap_m,
                                    .part = fixed->joint_gap_part,
                                    .joint = static_cast<std::int32_t>(fixed->gap_joint)};
  std::span<double> jacobian;
  if (reply.jacobian) {
    jacobian = {reply.jacobian->data(), static_cast<std::size_t>(reply.jacobian->size())};
  }
  arrays_of(message, *fixed)
      .take(count_at(message, 0), reply.motions)
      .take(count_at(message, 1), reply.wrenches)
      .take(jacobian)
      .take(count_at(message, 3), reply.message);
  return true;
}

std::optional<Reply> decode_reply(ByteView message) {
  Reply reply;
  if (!decode(message, reply)) return std::nullopt;
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
    packed.stand_in_mass_kg.push_back(port.stand_in.mass_kg);
    packed.stand_in_inertia_kg_m2.push_back(port.stand_in.inertia_kg_m2);
    packed.stand_in_gamma.push_back(port.stand_in.gamma);
    packed.stand_in_alpha_m.push_back(port.stand_in.alpha_m);
    packed.stand_in_alpha_f.push_back(port.stand_in.alpha_f);
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
  const auto packed = from_bytes(message, tandem_wire::handshake_t{}, {1, 1, 48, 1});
  if (!packed) return std::nullopt;
  Handshake handshake;
  handshake.header = unpack(packed->header);
  handshake.protocol_version = packed->protocol_version;
  handshake.tandem_version = unpack(packed->tandem_version);
  handshake.scenario_hash = static_cast<std::uint64_t>(packed->scenario_hash);
  std::istringstream names(unpack(packed->port_names));
  for (std::size_t p = 0; p < packed->port_length_m.size(); ++p) {
    PortInfo port{.name = {},
                  .length_m = packed->port_length_m[p],
                  .stand_in = {.mass_kg = packed->stand_in_mass_kg[p],
                               .inertia_kg_m2 = packed->stand_in_inertia_kg_m2[p],
                               .gamma = packed->stand_in_gamma[p],
                               .alpha_m = packed->stand_in_alpha_m[p],
                               .alpha_f = packed->stand_in_alpha_f[p]}};
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

}  // namespace tandem::wire
