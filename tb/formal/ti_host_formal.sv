// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// `ti_host` counts each ray and each hit, so that rays less hits are those inside a cycle before, and hits by status.
/// While a flush goes on no ray is taken; the engine hears of it when none waits in front, and it is over when the
/// engine had it and was idle.
module ti_host_formal #(
  parameter int unsigned NumStreams = 1
) (
  input logic                                  clk_i,
  input logic                                  rst_ni,
  input logic                                  irq_o,
  input logic                                  run_o,
  input logic                                  flush_o,
  input logic                                  idle_i,
  input logic                 [NumStreams-1:0] no_ray_i,
  input logic                 [NumStreams-1:0] no_hit_i,
  input logic                 [NumStreams-1:0] take_i,
  input logic                 [NumStreams-1:0] give_i,
  input ti_pkg::hit_t                          hit_i        [NumStreams],
  // What the registers hold and show.
  input logic                                  run,
  input logic                                  flush,
  input logic                 [           3:0] interrupts,
  input logic                 [           3:0] enabled,
  input ti_count_pkg::count_t                  rays_q,
  input ti_count_pkg::count_t                  hits_q,
  input logic                                  shows_idle,
  input logic                 [          31:0] invalid_rays,
  input logic                 [          31:0] memory_errors,
  input logic                 [          31:0] watchdogs
);
  `TI_STARTS_IN_RESET

  // Rays inside, what has passed, and all of it a cycle ago.
  typedef struct packed {
    ti_count_pkg::count_t rays_inside;
    ti_count_pkg::count_t taken;
    logic [2**$bits(ti_pkg::status_e)-1:0][31:0] by_status;
  } traffic_t;
  traffic_t traffic_q, traffic_q2;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      traffic_q  <= '0;
      traffic_q2 <= '0;
    end else begin
      traffic_q2 <= traffic_q;
      traffic_q.rays_inside <= traffic_q.rays_inside + $bits(
          rays_q
      )'($countones(
          take_i
      )) - $bits(
          rays_q
      )'($countones(
          give_i
      ));
      traffic_q.taken <= traffic_q.taken + $bits(rays_q)'($countones(take_i));
      for (int unsigned status = 0; status < 2 ** $bits(ti_pkg::status_e); status++) begin
        traffic_q.by_status[status] <= traffic_q.by_status[status] + 32'(ended(status));
      end
    end
  end
  function automatic int unsigned ended(int unsigned status);
    ended = 0;
    for (int unsigned s = 0; s < NumStreams; s++) begin
      if (give_i[s] && 32'(hit_i[s].status) == status) ended++;
    end
  endfunction

  // `ti_ray_in` takes a ray only while `run_o` is up.
  `TI_ASSUME(TakesWhileItMay, take_i != '0 -> run_o)

  `TI_ASSERT(EachRayIsCounted, rays_q == traffic_q2.taken)
  `TI_ASSERT(EachHitIsCounted, rays_q - hits_q == traffic_q2.rays_inside)
  `TI_ASSERT(InvalidRaysAreCounted, invalid_rays == traffic_q2.by_status[ti_pkg::InvalidRay])
  `TI_ASSERT(MemoryErrorsAreCounted, memory_errors == traffic_q2.by_status[ti_pkg::MemoryError])
  `TI_ASSERT(WatchdogsAreCounted, watchdogs == traffic_q2.by_status[ti_pkg::Watchdog])

  `TI_ASSERT(RunsUnlessItFlushes, run_o == (run && !flush))
  `TI_ASSERT(EngineHearsWhenNoneWaits, flush_o == (flush && no_ray_i == '1))
  `TI_ASSERT_NEXT(FlushGoesOnUntilTheEngineIsIdle, flush && !idle_i, flush)
  `TI_ASSERT_NEXT(FlushGoesOnUntilTheEngineHadIt, flush && $past(rst_ni && !flush_o), flush)
  `TI_ASSERT_NEXT(InterruptOfWhatIsEnabled, 1'b1, irq_o == ($past(interrupts & enabled) != '0))
  `TI_ASSERT_NEXT(IdleWhenNothingIsInside, 1'b1, shows_idle == $past
                  (idle_i && no_ray_i == '1 && no_hit_i == '1))
  `TI_COVER(FlushIsOver, !flush && $past(flush) && hits_q == 48'd1)
  `TI_COVER(Interrupts, irq_o && memory_errors == 32'd1)
endmodule : ti_host_formal

bind ti_host ti_host_formal #(
  .NumStreams(NumStreams)
) u_formal (
  .run(out.CONTROL.run.value),
  .interrupts({
    out.IRQ_STATUS.invalid_ray.value,
    out.IRQ_STATUS.memory_error.value,
    out.IRQ_STATUS.watchdog.value,
    out.IRQ_STATUS.drained.value
  }),
  .enabled({
    out.IRQ_ENABLE.invalid_ray.value,
    out.IRQ_ENABLE.memory_error.value,
    out.IRQ_ENABLE.watchdog.value,
    out.IRQ_ENABLE.drained.value
  }),
  .shows_idle(in.STATUS.idle.next),
  .invalid_rays(in.INVALID_RAYS.value.next),
  .memory_errors(in.MEMORY_ERRORS.value.next),
  .watchdogs(in.WATCHDOGS.value.next),
  .*
);
