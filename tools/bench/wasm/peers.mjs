// The other engines, each in a scene of `Stage`: one class per engine, with default settings, no damping, no sleeping.
import { readFile } from "node:fs/promises";

import RAPIER_DETERMINISTIC from "@dimforge/rapier3d-deterministic-compat";
import HavokPhysics from "@babylonjs/havok";
import initJolt from "jolt-physics";
import initJoltSimd from "jolt-physics/wasm-compat-multithread";
import * as RAPIER_SIMD from "./node_modules/@dimforge/rapier3d-simd/rapier.js"; // has no entry for Node

import { numbersOfPose } from "./lockstone.mjs";

const density = 1000; // kg/m^3
const gravity = -9.81; // m/s^2
const stepTime = 1 / 60; // s

/// A plane is a box in the other engines: 200 x 1 x 200 m, with its surface at the plane.
function solidOf(body) {
    if (body.kind !== "plane") return body;
    const [x, y, z] = body.position;
    return { ...body, kind: "box", half: [100, 0.5, 100], position: [x, y - 0.5, z] };
}

class Peer {
    constructor(stage) {
        this.stage = stage;
    }
    kickAll(tick) {
        for (const [body, x, y, z] of this.stage.kicks(tick)) this.kick(body, x, y, z);
    }
    poses() {
        const poses = new Float64Array(numbersOfPose * this.stage.bodies.length);
        this.stage.bodies.forEach((_, i) => poses.set(this.pose(i), numbersOfPose * i));
        return poses;
    }
}

class Rapier extends Peer {
    constructor(stage, api) {
        super(stage);
        this.api = api;
        this.images = [];
        this.use(new api.World({ x: 0, y: gravity, z: 0 }));
        this.world.timestep = stepTime;
        this.handles = stage.bodies.map((body) => this.add(solidOf(body)));
        this.use(this.world);
    }
    use(world) {
        this.world = world;
        this.bodies = this.handles?.map((handle) => world.getRigidBody(handle));
    }
    add({ kind, half: [hx, hy, hz], position: [x, y, z], rotation: [qx, qy, qz, qw], mass, friction }) {
        const { RigidBodyDesc, ColliderDesc } = this.api;
        const desc = mass === 0 ? RigidBodyDesc.fixed() : RigidBodyDesc.dynamic().setCanSleep(false);
        const body = this.world.createRigidBody(desc.setTranslation(x, y, z).setRotation({ x: qx, y: qy, z: qz, w: qw }));
        const shape = { sphere: () => ColliderDesc.ball(hx), box: () => ColliderDesc.cuboid(hx, hy, hz), capsule: () => ColliderDesc.capsule(hy, hx) };
        this.world.createCollider(shape[kind]().setDensity(density).setFriction(friction).setRestitution(0), body);
        return body.handle;
    }
    kick(index, x, y, z) {
        const body = this.bodies[index], v = body.linvel();
        body.setLinvel({ x: v.x + x, y: v.y + y, z: v.z + z }, true);
    }
    step() {
        this.world.step();
    }
    pose(index) {
        const p = this.bodies[index].translation(), q = this.bodies[index].rotation();
        return [p.x, p.y, p.z, q.x, q.y, q.z, q.w];
    }
    save(slot) {
        this.images[slot] = this.world.takeSnapshot();
    }
    restore(slot) {
        this.world.free();
        this.use(this.api.World.restoreSnapshot(this.images[slot]));
    }
    free() {
        this.world.free();
    }
}

class Jolt extends Peer {
    constructor(stage, api) {
        super(stage);
        this.api = api;
        this.images = [];
        this.jolt = new api.JoltInterface(this.settings());
        this.system = this.jolt.GetPhysicsSystem();
        this.system.SetGravity(new api.Vec3(0, gravity, 0));
        this.interface = this.system.GetBodyInterface();
        this.change = new api.Vec3(0, 0, 0);
        this.bodies = stage.bodies.map((body) => this.add(solidOf(body)));
        this.system.OptimizeBroadPhase();
    }
    settings() {  // two layers: moving bodies and static ones
        const { api } = this;
        const settings = new api.JoltSettings();
        settings.mMaxWorkerThreads = 0;
        const pairs = new api.ObjectLayerPairFilterTable(2);
        pairs.EnableCollision(0, 1), pairs.EnableCollision(1, 1);
        const layers = new api.BroadPhaseLayerInterfaceTable(2, 2);
        layers.MapObjectToBroadPhaseLayer(0, new api.BroadPhaseLayer(0)), layers.MapObjectToBroadPhaseLayer(1, new api.BroadPhaseLayer(1));
        settings.mObjectLayerPairFilter = pairs, settings.mBroadPhaseLayerInterface = layers;
        settings.mObjectVsBroadPhaseLayerFilter = new api.ObjectVsBroadPhaseLayerFilterTable(layers, 2, pairs, 2);
        return settings;
    }
    add({ kind, half: [hx, hy, hz], position, rotation, mass, friction }) {
        const { api } = this;
        const shapes = { sphere: () => new api.SphereShape(hx), box: () => new api.BoxShape(new api.Vec3(hx, hy, hz)), capsule: () => new api.CapsuleShape(hy, hx) };
        const motion = mass === 0 ? api.EMotionType_Static : api.EMotionType_Dynamic;
        const settings = new api.BodyCreationSettings(shapes[kind](), new api.RVec3(...position), new api.Quat(...rotation), motion, mass === 0 ? 0 : 1);
        settings.mFriction = friction, settings.mRestitution = 0, settings.mLinearDamping = 0, settings.mAngularDamping = 0, settings.mAllowSleeping = false;
        if (mass !== 0) {
            settings.mOverrideMassProperties = api.EOverrideMassProperties_CalculateInertia;
            settings.mMassPropertiesOverride.mMass = mass;
        }
        const body = this.interface.CreateBody(settings);
        this.interface.AddBody(body.GetID(), mass === 0 ? api.EActivation_DontActivate : api.EActivation_Activate);
        api.destroy(settings);
        return body;
    }
    kick(index, x, y, z) {
        this.change.Set(x, y, z);
        this.interface.AddLinearVelocity(this.bodies[index].GetID(), this.change);
    }
    step() {
        this.jolt.Step(stepTime, 1);
    }
    pose(index) {
        // Copies: both calls return views of one memory.
        const p = this.bodies[index].GetPosition(), at = [p.GetX(), p.GetY(), p.GetZ()];
        const q = this.bodies[index].GetRotation();
        return [...at, q.GetX(), q.GetY(), q.GetZ(), q.GetW()];
    }
    save(slot) {
        this.images[slot] ??= new this.api.StateRecorderImpl();
        this.images[slot].Clear();
        this.system.SaveState(this.images[slot]);
    }
    restore(slot) {
        this.images[slot].Rewind();
        this.system.RestoreState(this.images[slot]);
    }
    free() {
        for (const image of this.images) this.api.destroy(image);
        this.api.destroy(this.jolt);
    }
}

class Havok extends Peer {
    constructor(stage, api) {
        super(stage);
        this.api = api;
        this.world = this.of(api.HP_World_Create());
        api.HP_World_SetGravity(this.world, [0, gravity, 0]);
        api.HP_World_SetIdealStepTime(this.world, stepTime);
        this.shapes = [];
        this.bodies = stage.bodies.map((body) => this.add(solidOf(body)));
    }
    of([status, value]) {
        if (status !== this.api.Result.RESULT_OK) throw new Error(`Havok: status ${status.value}`);
        return value;
    }
    add({ kind, half: [hx, hy, hz], position, rotation, mass, friction }) {
        const { api } = this;
        const shapes = {
            sphere: () => api.HP_Shape_CreateSphere([0, 0, 0], hx),
            box: () => api.HP_Shape_CreateBox([0, 0, 0], [0, 0, 0, 1], [2 * hx, 2 * hy, 2 * hz]),
            capsule: () => api.HP_Shape_CreateCapsule([0, -hy, 0], [0, hy, 0], hx),
        };
        const shape = this.of(shapes[kind]()), combine = api.MaterialCombine;
        api.HP_Shape_SetMaterial(shape, [friction, friction, 0, combine.GEOMETRIC_MEAN, combine.MAXIMUM]);
        api.HP_Shape_SetDensity(shape, density);
        const body = this.of(api.HP_Body_Create());
        api.HP_Body_SetShape(body, shape);
        api.HP_Body_SetMotionType(body, mass === 0 ? api.MotionType.STATIC : api.MotionType.DYNAMIC);
        if (mass !== 0) api.HP_Body_SetMassProperties(body, this.of(api.HP_Shape_BuildMassProperties(shape)));
        api.HP_Body_SetLinearDamping(body, 0), api.HP_Body_SetAngularDamping(body, 0);
        api.HP_Body_SetQTransform(body, [position, rotation]);
        api.HP_World_AddBody(this.world, body, false);
        if (mass !== 0) api.HP_Body_SetActivationControl(body, api.ActivationControl.ALWAYS_ACTIVE);
        this.shapes.push(shape);
        return body;
    }
    kick(index, x, y, z) {
        const v = this.of(this.api.HP_Body_GetLinearVelocity(this.bodies[index]));
        this.api.HP_Body_SetLinearVelocity(this.bodies[index], [v[0] + x, v[1] + y, v[2] + z]);
    }
    step() {
        this.api.HP_World_Step(this.world, stepTime);
    }
    pose(index) {
        const [position, rotation] = this.of(this.api.HP_Body_GetQTransform(this.bodies[index]));
        return [...position, ...rotation];
    }
    free() {
        for (const body of this.bodies) this.api.HP_World_RemoveBody(this.world, body), this.api.HP_Body_Release(body);
        for (const shape of this.shapes) this.api.HP_Shape_Release(shape);
        this.api.HP_World_Release(this.world);
    }
}

/// The list of engines: a name, `make(stage)`, and whether the state can be saved.
export async function peers() {
    await RAPIER_DETERMINISTIC.init();
    const havok = await HavokPhysics({ wasmBinary: await readFile(new URL(import.meta.resolve("@babylonjs/havok/lib/esm/HavokPhysics.wasm"))) });
    const jolt = await initJolt(), joltSimd = await initJoltSimd();
    return [
        { name: "rapier-simd", make: async (stage) => new Rapier(stage, RAPIER_SIMD) },
        { name: "rapier-deterministic", make: async (stage) => new Rapier(stage, RAPIER_DETERMINISTIC) },
        { name: "Jolt", make: async (stage) => new Jolt(stage, jolt) },
        { name: "Jolt-simd", make: async (stage) => new Jolt(stage, joltSimd) },
        { name: "Havok", make: async (stage) => new Havok(stage, havok) },
    ];
}
