// A scene in Bullet: btDiscreteDynamicsWorld with its default solver settings.
//
// What it is given beyond defaults: exact inertia, no deactivation unless the scene allows it, square roots of the
// coefficients, as it multiplies those of a pair, and hulls of the size they have with 1 mm of margin included. A
// contestant may take hulls as they come; then they are 40 mm thicker, and quicker.
#include "engines/scene.h"

#ifdef LOCKSTONE_BULLET
#include <LinearMath/btGeometryUtil.h>
#include <LinearMath/btTransformUtil.h>
#include <btBulletDynamicsCommon.h>

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

/// Its faces are moved inwards by the margin that Bullet adds.
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

/// A mesh that owns its triangles.
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

class Bullet final : public Engine {
  public:
    Bullet(const Contestant& c, const Scene& scene)
        : dispatcher(&configuration), world(&dispatcher, &broad_phase, &solver, &configuration),
          attraction(scene.attraction), default_margins(c.default_margins), sleeping(scene.sleeping),
          steps(c.substeps == 0 ? 1 : c.substeps), step_time(1.0 / (c.rate * steps)) {
        world.setGravity(vec(scene.gravity));
        if (c.iterations != 0) world.getSolverInfo().m_numIterations = c.iterations;
        for (const Body& body : scene.bodies) add(body);
        for (const Joint& joint : scene.joints) join(joint);
    }
    ~Bullet() override {
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

    void add(const Body& body) {
        shapes.push_back(shape_with_parts(body));
        const btVector3 inertia = vec(solid_of(body.shape).inertia * body.mass);
        btRigidBody::btRigidBodyConstructionInfo info(scalar(body.mass), nullptr, shapes.back().get(),
                                                      inertia);
        info.m_startWorldTransform = pose_of(body.position, body.rotation);
        info.m_friction = scalar(std::sqrt(body.friction));
        info.m_restitution = scalar(std::sqrt(body.restitution));
        // A pair has rolling_a friction_b + rolling_b friction_a.
        if (body.rolling_resistance > 0)
            info.m_rollingFriction = scalar(body.rolling_resistance / (2 * std::sqrt(body.friction)));
        bodies.push_back(std::make_unique<btRigidBody>(info));
        if (!sleeping) bodies.back()->setActivationState(DISABLE_DEACTIVATION);
        bodies.back()->setLinearVelocity(vec(body.velocity));
        bodies.back()->setAngularVelocity(vec(body.spin));
        if (body.moves) {
            bodies.back()->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
            kinematic.push_back({bodies.back().get(), vec(body.velocity), vec(body.spin)});
        }
        world.addRigidBody(bodies.back().get());
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

    /// The frame of a joint, its x axis along the axis, in a body's axes.
    static btTransform frame_on(const btRigidBody& body, const Joint& joint, Turn turn) {
        const btTransform at(btQuaternion(scalar(turn.x), scalar(turn.y), scalar(turn.z), scalar(turn.w)),
                             vec(joint.anchor));
        return body.getCenterOfMassTransform().inverse() * at;
    }

    void join(const Joint& joint) {
        btRigidBody& a =
            joint.a < 0 ? btTypedConstraint::getFixedBody() : *bodies[static_cast<std::size_t>(joint.a)];
        btRigidBody& b = *bodies[static_cast<std::size_t>(joint.b)];
        const btScalar limit = scalar(joint.limit), speed = scalar(joint.motor_speed);
        if (joint.kind == Link::ball) {
            joints.push_back(std::make_unique<btPoint2PointConstraint>(
                a, b, a.getCenterOfMassTransform().inverse() * vec(joint.anchor),
                b.getCenterOfMassTransform().inverse() * vec(joint.anchor)));
        } else if (joint.kind == Link::hinge) { // about the z axis of its frames
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
    btDiscreteDynamicsWorld world;
    std::vector<std::unique_ptr<btCollisionShape>> shapes;
    std::vector<std::unique_ptr<btRigidBody>> bodies;
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
