#include "mbs_process/state.h"

#include "protocol/contract/hash.h"

namespace tandem::mbs {

std::uint64_t hash_of(const State& state) {
  StateHash hash;
  hash.add(std::int64_t{state.time.count()});
  for (const BodyState& body : state.bodies) {
    for (double x : body.p_WB) hash.add(x);
    for (double x : body.q_WB.coeffs()) hash.add(x);
    for (double x : body.v_WB) hash.add(x);
    for (double x : body.w_WB) hash.add(x);
  }
  for (const auto& coordinates : state.joint_coordinates) hash.add(coordinates);
  for (const Wrench& wrench : state.filtered) {
    for (double x : wrench.f_P_W) hash.add(x);
    for (double x : wrench.t_P_W) hash.add(x);
  }
  for (double work : {state.book.external_work_J, state.book.interface_work_J,
                      state.book.damping_loss_J, state.book.numerical_loss_J}) {
    hash.add(work);
  }
  return hash.value();
}

}  // namespace tandem::mbs
