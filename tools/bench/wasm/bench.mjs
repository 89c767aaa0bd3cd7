// The program that `run` starts: see README.md.
import { execFileSync } from "node:child_process";
import { cpus, loadavg } from "node:os";
import { parseArgs } from "node:util";

import { lockstone } from "./lockstone.mjs";
import { Bench } from "./measure.mjs";
import { peers } from "./peers.mjs";
import { printRollbacks, printScene, printVerdicts, verdicts } from "./report.mjs";

const scenes = [1, 2, 6], rollbackScene = 6;
const quickTicks = 30;

const { values: options, positionals: wanted } = parseArgs({
    allowPositionals: true,
    options: { module: { type: "string" }, native: { type: "string" }, runs: { type: "string", default: "3" }, json: { type: "boolean" }, quick: { type: "boolean" }, plant: { type: "boolean" } },
});
const say = options.json ? () => {} : console.log;
const problems = [];

function expect(good, sentence) {
    say(`${good ? "ok      " : "FAILED  "}${sentence}`);
    if (!good) problems.push(sentence);
}

const nativeHash = (number, ticks) => execFileSync(options.native, [`S${number}`, String(ticks)], { encoding: "utf8" }).trim();

/// Compares the hash with that of the engine compiled for this machine.
async function checkHash(bench, number) {
    const { ticks } = await bench.open(number), hash = await bench.hashAtEnd(number, options.plant), native = nativeHash(number, ticks);
    expect(hash === native, `S${number}: hash after ${ticks} ticks ${hash}, native ${native}`);
    return { scene: `S${number}`, ticks, hash, native };
}

async function quick(bench, numbers) {
    const rows = [];
    for (const number of numbers) {
        rows.push(await checkHash(bench, number));
        for (const engine of bench.engines) {
            const complaint = await bench.complaint(engine, number, quickTicks);
            expect(!complaint, `S${number}: ${engine.name}: ${complaint ?? `${quickTicks} ticks`}`);
        }
    }
    const twin = await bench.hashAtEnd(rollbackScene, true), { ticks } = await bench.open(rollbackScene);
    expect(twin !== nativeHash(rollbackScene, ticks), "planted: a start that differs by 2^-16 m/s is noticed");
    const [first] = bench.engines, frozen = { ...first, make: async (stage) => Object.assign(await first.make(stage), { step() {} }) };
    expect((await bench.complaint(frozen, 1, quickTicks)) === "nothing moves", "planted: an engine that does not move is noticed");
    const rollbacks = await bench.rollbacks(rollbackScene, 1);
    expect(rollbacks[0].is_exact, "S6: a rollback of Lockstone is exact");
    return { hashes: rows, rollbacks };
}

async function full(bench, numbers) {
    const rows = [], hashes = [];
    for (const number of numbers) {
        hashes.push(await checkHash(bench, number));
        rows.push(await bench.contest(number, Number(options.runs)));
        if (!options.json) printScene(rows.at(-1));
    }
    const rollbacks = numbers.includes(rollbackScene) ? await bench.rollbacks(rollbackScene) : undefined;
    if (rollbacks && !options.json) printRollbacks(`S${rollbackScene}`, rollbacks);
    const targets = verdicts(rows, rollbacks);
    if (!options.json) printVerdicts(targets);
    return { hashes, scenes: rows, rollbacks, targets };
}

const numbers = scenes.filter((number) => wanted.length === 0 || wanted.includes(`S${number}`));
const { module, engine } = await lockstone(options.module);
const bench = new Bench(module, [engine, ...(await peers())]);
const settings = { date: new Date().toISOString().slice(0, 10), node: process.version, v8: process.versions.v8, cpu: cpus()[0].model.trim(), load: loadavg()[0] };
say(`${settings.cpu}, Node ${settings.node}, load ${settings.load.toFixed(1)}; this thread's time, of each tick the least of ${options.runs} runs`);
const found = await (options.quick ? quick : full)(bench, numbers);
if (options.json) console.log(JSON.stringify({ settings, ...found, problems }, null, 1));
process.exit(problems.length === 0 ? 0 : 1);  // the workers of Jolt would keep the process alive
