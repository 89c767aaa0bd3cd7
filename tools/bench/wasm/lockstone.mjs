// The module that make.py builds: scenes, Lockstone's run of them, the quality of the poses of any engine. See
// module.cpp.
import { readFile } from "node:fs/promises";
import { WASI } from "node:wasi";

export const numbersOfPose = 7; // position, rotation
const kinds = ["sphere", "box", "capsule", "cylinder", "hull", "plane"];

/// A scene.
export class Stage {
    static async open(module, number) {
        const wasi = new WASI({ version: "preview1", returnOnExit: true });
        const instance = await WebAssembly.instantiate(module, wasi.getImportObject());
        wasi.initialize(instance);
        return new Stage(instance.exports, number);
    }

    constructor(call, number) {
        this.call = call;
        this.name = `S${number}`;
        const count = call.open(number);
        const [ticks, judgedAfter, rollbackFrom, stands] = this.numbers(call.facts(), 4);
        Object.assign(this, { ticks, judgedAfter, rollbackFrom, stands: stands !== 0 });
        this.bodies = Array.from({ length: count }, (_, i) => this.body(i));
    }

    numbers(address, count) {
        return new Float64Array(this.call.memory.buffer, address, count);
    }

    body(index) {
        const [kind, hx, hy, hz, px, py, pz, qx, qy, qz, qw, mass, friction] = this.numbers(this.call.body(index), 13);
        return { kind: kinds[kind], half: [hx, hy, hz], position: [px, py, pz], rotation: [qx, qy, qz, qw], mass, friction };
    }

    /// The actions of the scene's script before a tick: [body, x, y, z] each, a change of velocity [m/s].
    kicks(tick) {
        const address = this.call.kicks(tick);
        const [count] = this.numbers(address, 1);
        const flat = this.numbers(address, 1 + 4 * count);
        return Array.from({ length: count }, (_, i) => [...flat.subarray(1 + 4 * i, 5 + 4 * i)]);
    }

    /// The quality of the poses of all bodies, seven numbers for each body.
    judge(poses) {
        const room = this.call.room_for_poses();
        this.numbers(room, poses.length).set(poses);
        const [overlap, overlapStatic, sway, fallen, lost] = this.numbers(this.call.judge(), 5);
        return { overlap_mm: overlap, overlap_static_mm: overlapStatic, sway_mm: sway, fallen, lost };
    }
}

/// Lockstone in a scene. Every engine has `step`, `kick` and `poses`; some also have `save` and `restore` by slot.
class Lockstone {
    constructor(stage) {
        this.stage = stage;
        this.call = stage.call;
    }
    kickAll(tick) {
        this.call.script(tick);
    }
    step() {
        this.call.step();
    }
    poses() {
        return this.stage.numbers(this.call.poses(), numbersOfPose * this.stage.bodies.length).slice();
    }
    save(slot) {
        this.call.save(slot);
    }
    restore(slot) {
        this.call.restore(slot);
    }
    hash() {
        return BigInt.asUintN(64, this.call.hash()).toString(16).padStart(16, "0");
    }
    free() {}
}

export async function lockstone(path) {
    const module = await WebAssembly.compile(await readFile(path));
    return {
        module,
        engine: { name: "Lockstone", make: async (stage) => new Lockstone(await Stage.open(module, Number(stage.name.slice(1)))) },
    };
}
