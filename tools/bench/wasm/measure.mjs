// Runs scenes in several engines in turns and keeps their results. The clock of this thread times the ticks, so other
// work of the machine does not count.
import { Stage } from "./lockstone.mjs";

const block = 5;  // ticks that an engine runs before the next engine's turn
const rollbackDepth = 8, rollbackRepeats = 15;
const slots = { start: 0, ring: 1 };

export function mean(values) {
    return values.reduce((sum, value) => sum + value, 0) / values.length;
}
export function percentile(values, fraction) {
    return Float64Array.from(values).sort()[Math.trunc(fraction * (values.length - 1))];
}

export class Bench {
    /// `engines`: Lockstone first. `seconds`: undefined, or a clock [us] that replaces the thread's.
    constructor(module, engines) {
        Object.assign(this, { module, engines });
    }

    open(number) {
        return Stage.open(this.module, number);
    }

    time(stage, act) {
        const before = stage.call.thread_us();
        act();
        return stage.call.thread_us() - before;
    }

    advance(stage, lane, from, to) {
        for (let tick = from; tick < to; ++tick) {
            lane.runner.kickAll(tick);
            const spent = this.time(stage, () => lane.runner.step());
            if (tick < lane.us.length) lane.us[tick] = Math.min(lane.us[tick], spent);
        }
    }

    /// Runs every engine through `ticks` of a scene, and then up to `judgedAfter` if that is more.
    async once(stage, lanes, ticks, judgedAfter) {
        for (const lane of lanes) lane.runner = await lane.engine.make(stage);
        for (let tick = 0; tick < ticks; tick += block)
            for (const lane of lanes) this.advance(stage, lane, tick, Math.min(tick + block, ticks));
        for (const lane of lanes) {
            lane.hash = lane.runner.hash?.();
            this.advance(stage, lane, ticks, judgedAfter);
            if (judgedAfter > 0) lane.quality = stage.judge(lane.runner.poses());
            lane.runner.free();
        }
    }

    /// The least time of each tick over all runs counts, since every engine does the same work in each run.
    async contest(number, runs) {
        const stage = await this.open(number), { ticks } = stage;
        const lanes = this.engines.map((engine) => ({ engine, us: new Float64Array(ticks).fill(Infinity) }));
        for (let run = 0; run < runs; ++run) await this.once(stage, lanes, ticks, run === 0 ? stage.judgedAfter : 0);
        const rows = lanes.map(({ engine, us, quality }) => ({
            engine: engine.name, mean_ms: mean(us) / 1e3, median_ms: percentile(us, 0.5) / 1e3, p99_ms: percentile(us, 0.99) / 1e3, ...quality,
        }));
        return { scene: stage.name, bodies: stage.bodies.length, ticks, judged_after: stage.judgedAfter, stands: stage.stands, runs, hash: lanes[0].hash, engines: rows };
    }

    /// Eight ticks, then the same ticks as a rollback: restores the start, and saves after each tick.
    rollBack(stage, runner, from) {
        for (let k = 0; k < rollbackDepth; ++k) stage.kicks(from + k);  // computed in advance
        const ticks = (after) => {
            for (let k = 0; k < rollbackDepth; ++k) runner.kickAll(from + k), runner.step(), after(k);
        };
        const save = this.time(stage, () => runner.save(slots.start));
        const plain = this.time(stage, () => ticks(() => {}));
        const poses = runner.poses();
        const restore = this.time(stage, () => runner.restore(slots.start));
        runner.step(), ticks(() => {});  // makes a state to restore
        const rollback = this.time(stage, () => {
            runner.restore(slots.start);
            ticks((k) => runner.save(slots.ring + k));
        });
        return { plain, rollback, save, restore, exact: runner.poses().every((x, i) => Object.is(x, poses[i])) };
    }

    async rollbacks(number, repeats = rollbackRepeats) {
        const stage = await this.open(number), lanes = [];
        for (const engine of this.engines) {
            const runner = await engine.make(stage);
            if (runner.save) lanes.push({ engine, runner, samples: [] });
        }
        for (const { runner } of lanes) for (let tick = 0; tick < stage.rollbackFrom; ++tick) runner.kickAll(tick), runner.step();
        for (let i = 0; i < repeats; ++i)
            for (const lane of lanes) lane.samples.push(this.rollBack(stage, lane.runner, stage.rollbackFrom + rollbackDepth * i));
        return lanes.map(({ engine, runner, samples }) => {
            runner.free();
            const median = (key) => percentile(samples.map((sample) => sample[key]), 0.5);
            return { engine: engine.name, steps_us: median("plain"), rollback_us: median("rollback"), save_us: median("save"), restore_us: median("restore"), is_exact: samples.every((s) => s.exact) };
        });
    }

    /// Lockstone's hash at the end of a scene. `planted`: one body begins 2^-16 m/s faster.
    async hashAtEnd(number, planted = false) {
        const stage = await this.open(number), { call } = stage;
        if (planted) call.plant(stage.bodies.length - 1);
        for (let tick = 0; tick < stage.ticks; ++tick) call.script(tick), call.step();
        return BigInt.asUintN(64, call.hash()).toString(16).padStart(16, "0");
    }

    /// A sentence about a fault in an engine's first ticks in a scene; undefined if bodies move and none is lost.
    async complaint(engine, number, ticks) {
        const stage = await this.open(number), runner = await engine.make(stage), before = runner.poses();
        for (let tick = 0; tick < ticks; ++tick) runner.kickAll(tick), runner.step();
        const after = runner.poses(), { lost } = stage.judge(after);
        runner.free();
        const moved = after.reduce((most, x, i) => Math.max(most, Math.abs(x - before[i])), 0);
        if (!after.every(Number.isFinite)) return "a pose is no number";
        if (lost > 0) return `lost ${lost} bodies`;
        return moved < 1e-5 ? "nothing moves" : undefined;  // [m]
    }
}
