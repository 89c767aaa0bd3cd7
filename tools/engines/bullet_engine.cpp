// Runs a scene in Bullet: btDiscreteDynamicsWorld with its default solver settings.
//
// The adapter differs from the defaults as follows. Inertia is exact. Deactivation is off unless the scene allows
// sleeping. It passes the square roots of the coefficients, because Bullet multiplies those of a pair. Hulls keep their
// described size, 1 mm of margin included; with Contestant::default_margins they get Bullet's margin, are 40 mm
// thicker, and run faster.
#include "engines/scene.h"

#ifdef LOCKSTONE_BULLET
#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletDynamics/Character/btKinematicCharacterController.h>
#include <BulletDynamics/Vehicle/btRaycastVehicle.h>
#include <LinearMath/btGeometryUtil.h>
#include <LinearMath/btTransformUtil.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <set>

namespace engines {

namespace {

constexpr btScalar scalar(double x) { return static_cast<btScalar>(x); }
btVector3 vec(V3 v) { return {scalar(v.x), scalar(v.y), scalar(v.z)}; }
btTransform pose_of(V3 position, Turn q) {
    return btTransform(btQuaternion(scalar(q.x), scalar(q.y), scalar(q.z), scalar(q.w)), vec(position));
}
V3 back(const btVector3& v) { return {double{v.x()}, double{v.y()}, double{v.z()}}; }

std::unique_ptr<btCollisionShape> hull_of_points(const Shape& shape) {
    auto hull = std::make_unique<btConvexHullShape>();
    for (V3 p : shape.points) hull->addPoint(vec(p), false);
    hull->recalcLocalAabb();
    return hull;
}

/// A hull whose faces are moved inwards by the margin that Bullet adds.
std::unique_ptr<btCollisionShape> hull_of(const Shape& shape) {
    constexpr btScalar margin = scalar(0.001);
    btAlignedObjectArray<btVector3> given, planes, shrunk;
    for (V3 p : shape.points) given.push_back(vec(p));
    btGeometryUtil::getPlaneEquationsFromVertices(given, planes);
    for (int i = 0; i < planes.size(); ++i) planes[i].setW(planes[i].w() + margin);
    btGeometryUtil::getVerticesFromPlaneEquations(planes, shrunk);
    auto hull = std::make_unique<btConvexHullShape>();
    for (int i = 0; i < shrunk.size(); ++i) hull->addPoint(shrunk[i], false);
    hull->recalcLocalAabb();
    hull->setMargin(margin);
    return hull;
}

/// A triangle mesh that owns its triangles.
struct Mesh final : btBvhTriangleMeshShape {
    explicit Mesh(std::unique_ptr<btTriangleMesh> made)
        : btBvhTriangleMeshShape(made.get(), true), triangles(std::move(made)) {}
    std::unique_ptr<btTriangleMesh> triangles;
};

std::unique_ptr<btCollisionShape> mesh_of(const Shape& shape) {
    auto triangles = std::make_unique<btTriangleMesh>();
    for (const std::vector<int>& face : shape.faces) {
        const auto corner = [&](std::size_t i) {
            return vec(shape.points[static_cast<std::size_t>(face[i])]);
        };
        triangles->addTriangle(corner(0), corner(1), corner(2));
    }
    return std::make_unique<Mesh>(std::move(triangles));
}

std::unique_ptr<btCollisionShape> shape_of(const Shape& shape, bool default_margins) {
    const V3 h = shape.half;
    switch (shape.kind) {
    case Kind::sphere:
        return std::make_unique<btSphereShape>(scalar(h.x));
    case Kind::box:
        return std::make_unique<btBoxShape>(vec(h));
    case Kind::capsule:
        return std::make_unique<btCapsuleShape>(scalar(h.x), scalar(2 * h.y));
    case Kind::cylinder:
        return std::make_unique<btCylinderShape>(vec(h));
    case Kind::hull:
        return default_margins ? hull_of_points(shape) : hull_of(shape);
    case Kind::mesh:
        return mesh_of(shape);
    case Kind::plane:
        break;
    }
    return std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), scalar(0));
}

/// A character: a capsule without a body, which an action of the world moves.
struct Walker {
    Walker(btDiscreteDynamicsWorld& world, V3 feet) : capsule(scalar(0.3), scalar(1.2)) {
        ghost.setWorldTransform(pose_of(feet + V3{0, 0.9, 0}, {}));
        ghost.setCollisionShape(&capsule);
        ghost.setCollisionFlags(btCollisionObject::CF_CHARACTER_OBJECT);
        mover = std::make_unique<btKinematicCharacterController>(&ghost, &capsule, scalar(0.35),
                                                                 btVector3(0, 1, 0));
        using Filter = btBroadphaseProxy;
        world.addCollisionObject(&ghost, Filter::CharacterFilter,
                                 Filter::StaticFilter | Filter::DefaultFilter | Filter::CharacterFilter);
        world.addAction(mover.get());
    }
    btCapsuleShape capsule;
    btPairCachingGhostObject ghost{};
    std::unique_ptr<btKinematicCharacterController> mover = nullptr;
};

/// A car with ray-cast wheels.
struct Vehicle {
    Vehicle(btDiscreteDynamicsWorld& world, btRigidBody& chassis, V3 hub)
        : caster(&world), car(tuning, &chassis, &caster) {
        car.setCoordinateSystem(0, 1, 2);
        tuning.m_suspensionStiffness = scalar(22), tuning.m_suspensionDamping = scalar(4.2);
        tuning.m_suspensionCompression = scalar(2.8), tuning.m_frictionSlip = scalar(1.1);
        for (const double z : {1.0, -1.0})
            for (const double x : {1.0, -1.0})
                car.addWheel(vec({x * hub.x, hub.y + 0.3, z * hub.z}), btVector3(0, -1, 0),
                             btVector3(-1, 0, 0), scalar(0.3), scalar(0.35), tuning, z > 0);
        world.addVehicle(&car);
    }
    btRaycastVehicle::btVehicleTuning tuning{};
    btDefaultVehicleRaycaster caster;
    btRaycastVehicle car;
};

/// Collects the bodies that a shape overlaps.
struct Overlapped final : btCollisionWorld::ContactResultCallback {
    btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
                             const btCollisionObjectWrapper* other, int, int) override {
        if (point.getDistance() <= 0) found.insert(other->getCollisionObject());
        return 0;
    }
    std::set<const btCollisionObject*> found = {};
};

class Bullet final : public Engine {
  public:
    Bullet(const Contestant& c, const Scene& scene)
        : dispatcher(&configuration), world(&dispatcher, &broad_phase, &solver, &configuration),
          attraction(scene.attraction), default_margins(c.default_margins), sleeping(scene.sleeping),
          steps(c.substeps == 0 ? 1 : c.substeps), step_time(1.0 / (c.rate * steps)) {
        world.setGravity(vec(scene.gravity));
        if (c.iterations != 0) world.getSolverInfo().m_numIterations = c.iterations;
        for (const Body& body : scene.bodies) add(body);
        for (const Joint& joint : scene.joints) join(scene, joint);
        for (const Shape& probe : scene.probes) probes.push_back(shape_of(probe, default_margins));
        for (const Car& car : scene.cars) {
            btRigidBody& chassis = *bodies[static_cast<std::size_t>(car.chassis)];
            vehicles.push_back(std::make_unique<Vehicle>(world, chassis, car.hub));
        }
        if (!scene.walkers.empty()) world.getPairCache()->setInternalGhostPairCallback(&ghost_pairs);
        for (const V3 feet : scene.walkers) walkers.push_back(std::make_unique<Walker>(world, feet));
    }
    ~Bullet() override {
        for (const auto& walker : walkers) {
            world.removeAction(walker->mover.get());
            world.removeCollisionObject(&walker->ghost);
        }
        for (const auto& vehicle : vehicles) world.removeVehicle(&vehicle->car);
        for (const auto& joint : joints) world.removeConstraint(joint.get());
        for (const auto& body : bodies) world.removeRigidBody(body.get());
    }

    State state(int body) const override {
        const btRigidBody& b = *bodies[static_cast<std::size_t>(body)];
        const btQuaternion q = b.getOrientation();
        return {back(b.getCenterOfMassPosition()),
                back(b.getLinearVelocity()),
                back(b.getAngularVelocity()),
                {double{q.x()}, double{q.y()}, double{q.z()}, double{q.w()}}};
    }

    void kick(int body, V3 change) override {
        btRigidBody& b = *bodies[static_cast<std::size_t>(body)];
        b.setLinearVelocity(b.getLinearVelocity() + vec(change));
    }

    void walk(int walker, V3 velocity) override {
        walkers[static_cast<std::size_t>(walker)]->mover->setWalkDirection(vec(velocity * step_time));
    }

    void drive(int car, double throttle, double steer) override {
        btRaycastVehicle& driven = vehicles[static_cast<std::size_t>(car)]->car;
        for (const int rear : {2, 3}) driven.applyEngineForce(scalar(3000 * throttle), rear);
        for (const int front : {0, 1}) driven.setSteeringValue(scalar(-0.6 * steer), front);
    }

    int add(const Body& body) override {
        shapes.push_back(shape_with_parts(body));
        bodies.push_back(create(body, *shapes.back()));
        return static_cast<int>(bodies.size()) - 1;
    }

    void replace(int number, const Body& body) override {
        std::unique_ptr<btRigidBody>& old = bodies[static_cast<std::size_t>(number)];
        btCollisionShape& shape = *old->getCollisionShape();
        world.removeRigidBody(old.get());
        old = create(body, shape);
    }

    double cast_ray(V3 from, V3 way) const override {
        const btVector3 start = vec(from), end = vec(from + way);
        btCollisionWorld::ClosestRayResultCallback hit(start, end);
        world.rayTest(start, end, hit);
        return double{hit.m_closestHitFraction};
    }

    double cast(int probe, V3 from, V3 way) const override {
        btCollisionWorld::ClosestConvexResultCallback hit(vec(from), vec(from + way));
        const auto& shape = static_cast<const btConvexShape&>(*probes[static_cast<std::size_t>(probe)]);
        world.convexSweepTest(&shape, pose_of(from, {}), pose_of(from + way, {}), hit);
        return double{hit.m_closestHitFraction};
    }

    int overlap(int probe, V3 at) const override {
        btCollisionObject asks;
        asks.setCollisionShape(probes[static_cast<std::size_t>(probe)].get());
        asks.setWorldTransform(pose_of(at, {}));
        Overlapped overlapped;
        world.contactTest(&asks, overlapped);
        return static_cast<int>(overlapped.found.size());
    }

  private:
    void tick() override {
        for (int i = 0; i < steps; ++i) {
            if (attraction != 0) attract();
            for (const Moved& moved : kinematic) {
                btTransform next;
                btTransformUtil::integrateTransform(moved.body->getWorldTransform(), moved.velocity,
                                                    moved.spin, scalar(step_time), next);
                moved.body->setWorldTransform(next);
            }
            world.stepSimulation(scalar(step_time), 0); // one step of exactly this time
        }
    }

    std::unique_ptr<btRigidBody> create(const Body& body, btCollisionShape& shape) {
        const btVector3 inertia = vec(solid_of(body).inertia * body.mass);
        btRigidBody::btRigidBodyConstructionInfo info(scalar(body.mass), nullptr, &shape, inertia);
        info.m_startWorldTransform = pose_of(body.position, body.rotation);
        info.m_friction = scalar(std::sqrt(body.friction));
        info.m_restitution = scalar(std::sqrt(body.restitution));
        // Bullet computes rolling_a friction_b + rolling_b friction_a for a pair.
        if (body.rolling_resistance > 0)
            info.m_rollingFriction = scalar(body.rolling_resistance / (2 * std::sqrt(body.friction)));
        auto made = std::make_unique<btRigidBody>(info);
        if (!sleeping) made->setActivationState(DISABLE_DEACTIVATION);
        made->setLinearVelocity(vec(body.velocity));
        made->setAngularVelocity(vec(body.spin));
        if (body.bullet) {
            const V3 h = body.shape.half;
            const double least = std::min({h.x, h.y, h.z});
            made->setCcdMotionThreshold(scalar(least));
            made->setCcdSweptSphereRadius(scalar(0.8 * least));
        }
        if (body.moves) {
            made->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
            kinematic.push_back({made.get(), vec(body.velocity), vec(body.spin)});
        }
        world.addRigidBody(made.get());
        return made;
    }

    std::unique_ptr<btCollisionShape> shape_with_parts(const Body& body) {
        if (body.parts.empty()) return shape_of(body.shape, default_margins);
        auto whole = std::make_unique<btCompoundShape>();
        const auto add_part = [&](const Shape& shape, const btTransform& at) {
            shapes.push_back(shape_of(shape, default_margins));
            whole->addChildShape(at, shapes.back().get());
        };
        add_part(body.shape, btTransform::getIdentity());
        for (const Part& part : body.parts) add_part(part.shape, pose_of(part.position, part.rotation));
        return whole;
    }

    /// The frame of a joint in a body's axes; its x axis is the axis of the joint.
    static btTransform frame_on(const btRigidBody& body, const Joint& joint, Turn turn) {
        const btTransform at(btQuaternion(scalar(turn.x), scalar(turn.y), scalar(turn.z), scalar(turn.w)),
                             vec(joint.anchor));
        return body.getCenterOfMassTransform().inverse() * at;
    }

    /// Joins by a ball or hinge with limits, springs or friction.
    void join_rich(const Scene& scene, const Joint& joint, btRigidBody& a, btRigidBody& b) {
        const Turn plain = from_x_to(joint.axis);
        const Joint::Frames frames = joint.frames.value_or(Joint::Frames{.a = plain, .b = plain});
        auto made = std::make_unique<btGeneric6DofSpring2Constraint>(a, b, frame_on(a, joint, frames.a),
                                                                     frame_on(b, joint, frames.b));
        made->setLinearLowerLimit(btVector3(0, 0, 0));
        made->setLinearUpperLimit(btVector3(0, 0, 0));
        const bool hinge = joint.kind == Link::hinge;
        // In Bullet a lower limit above the upper one leaves the axis free. The second of three angles must stay below
        // a right angle.
        const double twist = joint.frames ? 0 : joint.limit != 0 ? joint.limit : -1;
        const double swing = hinge ? 0 : frames.swing == 0 ? -1 : frames.swing;
        const double lower = joint.frames ? frames.lower : -twist,
                     upper = joint.frames ? frames.upper : twist;
        made->setAngularLowerLimitReversed(vec({lower, -std::min(swing, 1.5), -swing}));
        made->setAngularUpperLimitReversed(vec({upper, std::min(swing, 1.5), swing}));
        const Body& moved = scene.bodies[static_cast<std::size_t>(joint.b)];
        const double arm = length(joint.anchor - moved.position);
        const double inertia = moved.mass * (arm * arm + solid_of(moved).inertia.x);
        for (int angle = 3; angle < (hinge ? 4 : 6); ++angle) {
            made->enableMotor(angle, joint.friction != 0);
            made->setTargetVelocity(angle, 0);
            made->setMaxMotorForce(angle, scalar(joint.friction));
            if (joint.spring_hertz == 0) continue;
            const double rate = 2 * pi * joint.spring_hertz;
            made->enableSpring(angle, true);
            made->setStiffness(angle, scalar(inertia * rate * rate));
            made->setDamping(angle, scalar(2 * joint.spring_damping * inertia * rate));
        }
        joints.push_back(std::move(made));
    }

    void join(const Scene& scene, const Joint& joint) {
        btRigidBody& a =
            joint.a < 0 ? btTypedConstraint::getFixedBody() : *bodies[static_cast<std::size_t>(joint.a)];
        btRigidBody& b = *bodies[static_cast<std::size_t>(joint.b)];
        const btScalar limit = scalar(joint.limit), speed = scalar(joint.motor_speed);
        if (joint.frames || joint.friction != 0 || joint.spring_hertz != 0) {
            join_rich(scene, joint, a, b);
        } else if (joint.kind == Link::ball) {
            joints.push_back(std::make_unique<btPoint2PointConstraint>(
                a, b, a.getCenterOfMassTransform().inverse() * vec(joint.anchor),
                b.getCenterOfMassTransform().inverse() * vec(joint.anchor)));
        } else if (joint.kind == Link::hinge) { // turns about the z axis of its frames
            const Turn turn = from_z_to(joint.axis);
            auto hinge =
                std::make_unique<btHingeConstraint>(a, b, frame_on(a, joint, turn), frame_on(b, joint, turn));
            if (limit != 0) hinge->setLimit(-limit, limit);
            if (joint.motor_force != 0)
                hinge->enableAngularMotor(true, speed, scalar(joint.motor_force * step_time));
            joints.push_back(std::move(hinge));
        } else {
            const Turn turn = from_x_to(joint.axis);
            auto slider = std::make_unique<btSliderConstraint>(a, b, frame_on(a, joint, turn),
                                                               frame_on(b, joint, turn), true);
            slider->setLowerLinLimit(limit != 0 ? -limit : scalar(1));
            slider->setUpperLinLimit(limit != 0 ? limit : scalar(-1));
            slider->setLowerAngLimit(0);
            slider->setUpperAngLimit(0);
            slider->setPoweredLinMotor(joint.motor_force != 0);
            slider->setTargetLinMotorVelocity(speed);
            slider->setMaxLinMotorForce(scalar(joint.motor_force));
            joints.push_back(std::move(slider));
        }
        world.addConstraint(joints.back().get(), true);
    }

    void attract() {
        for (const auto& body : bodies) {
            if (body->getInvMass() == 0) continue;
            const V3 p = back(body->getCenterOfMassPosition());
            const double r = length(p);
            body->applyCentralForce(vec(p * (-attraction / (r * r * r) / double{body->getInvMass()})));
        }
    }

    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher;
    btDbvtBroadphase broad_phase;
    btSequentialImpulseConstraintSolver solver;
    mutable btDiscreteDynamicsWorld world; ///< queries of the world are not const
    std::vector<std::unique_ptr<btCollisionShape>> shapes;
    std::vector<std::unique_ptr<btCollisionShape>> probes;
    std::vector<std::unique_ptr<btRigidBody>> bodies;
    btGhostPairCallback ghost_pairs;
    std::vector<std::unique_ptr<Walker>> walkers;
    std::vector<std::unique_ptr<Vehicle>> vehicles;
    struct Moved {
        btRigidBody* body;
        btVector3 velocity, spin;
    };
    std::vector<Moved> kinematic;
    std::vector<std::unique_ptr<btTypedConstraint>> joints;
    double attraction;
    bool default_margins;
    bool sleeping;
    int steps;
    double step_time;
};

} // namespace

std::unique_ptr<Engine> make_bullet(const Contestant& contestant, const Scene& scene) {
    return std::make_unique<Bullet>(contestant, scene);
}

} // namespace engines
#endif
