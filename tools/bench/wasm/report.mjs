// Tables and verdicts of the benchmark.
const number = (x) => (x === undefined ? "" : x >= 1000 ? Math.round(x).toLocaleString("en") : x.toPrecision(3));

function row(cells) {
    return "    " + cells[0].padEnd(22) + cells.slice(1).map((cell) => String(cell).padStart(10)).join("");
}

const meanOf = (scene, name) => scene.engines.find((row) => row.engine === name).mean_ms;

export function printScene(scene) {
    const base = meanOf(scene, "rapier-simd");
    console.log(`${scene.scene}  ${scene.bodies} bodies, ${scene.ticks} ticks timed, judged after ${scene.judged_after}; hash ${scene.hash}`);
    console.log(row(["", "mean ms", "median", "p99", "/ rapier", "overlap", "of static", "sway mm", "fallen", "lost"]));
    for (const e of scene.engines)
        console.log(row([e.engine, number(e.mean_ms), number(e.median_ms), number(e.p99_ms), (e.mean_ms / base).toFixed(2), number(e.overlap_mm), number(e.overlap_static_mm),
            ...(scene.stands ? [number(e.sway_mm), e.fallen] : ["", ""]), e.lost]));
}

export function printRollbacks(scene, rows) {
    console.log(`rollback of eight ticks of ${scene}, us`);
    console.log(row(["", "rollback", "8 ticks", "save", "restore", "exact"]));
    for (const r of rows) console.log(row([r.engine, number(r.rollback_us), number(r.steps_us), number(r.save_us), number(r.restore_us), r.is_exact ? "yes" : "no"]));
}

/// The bounds of the engine's plan for WebAssembly with vectors.
export function verdicts(scenes, rollbacks) {
    const list = [];
    for (const scene of scenes.filter(({ scene }) => scene === "S1" || scene === "S2")) {
        const found = meanOf(scene, "Lockstone") / meanOf(scene, "rapier-simd");
        list.push({ what: `${scene.scene}: ours / rapier-simd`, found, must: "at most 1", good: found <= 1 });
    }
    if (rollbacks) {
        const jolt = Math.min(...rollbacks.filter(({ engine }) => engine.startsWith("Jolt")).map((r) => r.rollback_us));
        const found = jolt / rollbacks.find(({ engine }) => engine === "Lockstone").rollback_us;
        list.push({ what: "S6: rollback of eight ticks, the faster Jolt's / ours", found, must: "at least 3", good: found >= 3 });
    }
    return list;
}

export function printVerdicts(list) {
    for (const { what, found, must, good } of list) console.log(`    ${what.padEnd(56)} ${number(found).padStart(8)}, must be ${must}: ${good ? "held" : "MISSED"}`);
}
