// Runs a scene in ODE: dWorldQuickStep with its default parameters.
//
// Contacts follow the recommendations of ODE's manual: friction in proportion to the normal force (dContactApprox1), a
// surface layer of 1 mm against jitter. In ODE capsules and cylinders lie along z, so the adapter turns them.
#include "engines/scene.h"

#ifdef LOCKSTONE_ODE
#include <ode/ode.h>

#include <array>
#include <deque>

namespace engines {

namespace {

/// Initialises the library once for the program.
struct Library {
    Library() { dInitODE2(0), dAllocateODEDataForThread(static_cast<unsigned>(dAllocateMaskAll)); }
    ~Library() { dCloseODE(); }
};

/// The data of a convex geometry. dCreateConvex keeps pointers to it for the lifetime of the geometry.
struct Convex {
    std::vector<dReal> planes, points;
    std::vector<unsigned> polygons;
};

/// The data of a triangle mesh. ODE keeps pointers to it for the lifetime of the mesh.
struct Mesh {
    std::vector<double> points;
    std::vector<dTriIndex> corners;
    dTriMeshDataID data;
};

Convex convex_of(const Shape& hull) {
    Convex c;
    for (V3 p : hull.points) c.points.insert(c.points.end(), {p.x, p.y, p.z});
    for (const std::vector<int>& face : hull.faces) {
        const auto at = [&](std::size_t i) { return hull.points[static_cast<std::size_t>(face[i])]; };
        const V3 n = cross(at(1) - at(0), at(2) - at(0)), unit = n / length(n);
        c.planes.insert(c.planes.end(), {unit.x, unit.y, unit.z, dot(unit, at(0))});
        c.polygons.push_back(static_cast<unsigned>(face.size()));
        for (int i : face) c.polygons.push_back(static_cast<unsigned>(i));
    }
    return c;
}

class Ode final : public Engine {
  public:
    Ode(const Contestant& c, const Scene& s)
        : scene(s), steps(c.substeps == 0 ? 1 : c.substeps), step_time(1.0 / (c.rate * steps)) {
        static Library library;
        world = dWorldCreate();
        space = dHashSpaceCreate(nullptr);
        contacts = dJointGroupCreate(0);
        dWorldSetGravity(world, s.gravity.x, s.gravity.y, s.gravity.z);
        dWorldSetContactSurfaceLayer(world, 0.001);
        dWorldSetAutoDisableFlag(world, s.sleeping);
        if (c.iterations != 0) dWorldSetQuickStepNumIterations(world, c.iterations);
        for (const Body& body : scene.bodies) create(body);
        for (const Joint& joint : scene.joints) join(joint);
    }
    ~Ode() override {
        dJointGroupDestroy(contacts);
        dSpaceDestroy(space);
        for (const Mesh& mesh : meshes) dGeomTriMeshDataDestroy(mesh.data);
        dWorldDestroy(world);
    }

    State state(int body) const override {
        const dBodyID b = bodies[static_cast<std::size_t>(body)];
        if (b == nullptr) {
            const Body& still = scene.bodies[static_cast<std::size_t>(body)];
            return {still.position, {}, {}, still.rotation};
        }
        const dReal *p = dBodyGetPosition(b), *v = dBodyGetLinearVel(b), *w = dBodyGetAngularVel(b);
        const dReal* q = dBodyGetQuaternion(b);
        return {{p[0], p[1], p[2]}, {v[0], v[1], v[2]}, {w[0], w[1], w[2]}, {q[1], q[2], q[3], q[0]}};
    }

    void kick(int body, V3 change) override {
        const dBodyID b = bodies[static_cast<std::size_t>(body)];
        const dReal* v = dBodyGetLinearVel(b);
        dBodySetLinearVel(b, v[0] + change.x, v[1] + change.y, v[2] + change.z);
    }

  private:
    void tick() override {
        for (int i = 0; i < steps; ++i) {
            if (scene.attraction != 0) attract();
            dSpaceCollide(space, this,
                          [](void* self, dGeomID a, dGeomID b) { static_cast<Ode*>(self)->collide(a, b); });
            dWorldQuickStep(world, step_time);
            dJointGroupEmpty(contacts);
        }
    }

    const Body& body_of(dGeomID geometry) const {
        return scene.bodies[reinterpret_cast<std::size_t>(dGeomGetData(geometry))];
    }

    void collide(dGeomID a, dGeomID b) {
        constexpr int contacts_max = 8;
        std::array<dContact, contacts_max> found{};
        const Body &of_a = body_of(a), &of_b = body_of(b);
        if (of_a.mass == 0 && of_b.mass == 0) return;
        if (dAreConnectedExcluding(dGeomGetBody(a), dGeomGetBody(b), dJointTypeContact)) return;
        const int count = dCollide(a, b, contacts_max, &found[0].geom, sizeof(dContact));
        for (int i = 0; i < count; ++i) {
            dContact& contact = found[static_cast<std::size_t>(i)];
            contact.surface.mode = dContactApprox1;
            contact.surface.mu = std::sqrt(of_a.friction * of_b.friction);
            const double bounce = std::max(of_a.restitution, of_b.restitution);
            if (bounce > 0) {
                contact.surface.mode |= dContactBounce;
                contact.surface.bounce = bounce;
                contact.surface.bounce_vel = 0.2; // as in Bullet
            }
            const double rolling = std::max(of_a.rolling_resistance, of_b.rolling_resistance);
            if (rolling > 0) {
                contact.surface.mode |= dContactRolling;
                contact.surface.rho = contact.surface.rho2 = contact.surface.rhoN = rolling;
            }
            convey(of_a, of_b, contact);
            dJointAttach(dJointCreateContact(world, contacts, &contact), dGeomGetBody(a), dGeomGetBody(b));
        }
    }

    /// Adds the velocity of a conveyor's surface, along the first friction direction.
    static void convey(const Body& a, const Body& b, dContact& contact) {
        const V3 surface = rotate(a.rotation, a.surface_velocity) - rotate(b.rotation, b.surface_velocity);
        const V3 normal{contact.geom.normal[0], contact.geom.normal[1], contact.geom.normal[2]};
        const V3 along = surface - normal * dot(normal, surface);
        const double speed = length(along);
        if (speed < 1e-9) return;
        contact.surface.mode |= dContactFDir1 | dContactMotion1;
        contact.fdir1[0] = along.x / speed, contact.fdir1[1] = along.y / speed,
        contact.fdir1[2] = along.z / speed;
        contact.surface.motion1 = -speed;
    }

    dGeomID geometry_of(const Shape& shape) {
        const V3 h = shape.half;
        switch (shape.kind) {
        case Kind::sphere:
            return dCreateSphere(space, h.x);
        case Kind::box:
            return dCreateBox(space, 2 * h.x, 2 * h.y, 2 * h.z);
        case Kind::capsule:
            return dCreateCapsule(space, h.x, 2 * h.y);
        case Kind::cylinder:
            return dCreateCylinder(space, h.x, 2 * h.y);
        case Kind::hull: {
            const Convex& c = convex.emplace_back(convex_of(shape));
            return dCreateConvex(space, c.planes.data(), static_cast<unsigned>(c.planes.size() / 4),
                                 c.points.data(), static_cast<unsigned>(c.points.size() / 3),
                                 c.polygons.data());
        }
        case Kind::mesh:
            return mesh_of(shape);
        case Kind::plane:
            break;
        }
        return nullptr;
    }

    dGeomID mesh_of(const Shape& shape) {
        Mesh& mesh = meshes.emplace_back();
        for (V3 p : shape.points) mesh.points.insert(mesh.points.end(), {p.x, p.y, p.z});
        for (const std::vector<int>& face : shape.faces)
            for (int corner : face) mesh.corners.push_back(static_cast<dTriIndex>(corner));
        mesh.data = dGeomTriMeshDataCreate();
        dGeomTriMeshDataBuildDouble(mesh.data, mesh.points.data(), 3 * sizeof(double),
                                    static_cast<int>(shape.points.size()), mesh.corners.data(),
                                    static_cast<int>(mesh.corners.size()), 3 * sizeof(dTriIndex));
        return dCreateTriMesh(space, mesh.data, nullptr, nullptr, nullptr);
    }

    void create(const Body& body) {
        dBodyID b = nullptr;
        if (body.mass != 0 || body.moves) {
            b = dBodyCreate(world);
            if (body.moves) dBodySetKinematic(b);
            if (body.mass != 0) set_mass(b, body);
            dBodySetPosition(b, body.position.x, body.position.y, body.position.z);
            const Turn q = body.rotation;
            const dQuaternion turn = {q.w, q.x, q.y, q.z};
            dBodySetQuaternion(b, turn);
            dBodySetLinearVel(b, body.velocity.x, body.velocity.y, body.velocity.z);
            dBodySetAngularVel(b, body.spin.x, body.spin.y, body.spin.z);
        }
        bodies.push_back(b);
        attach(b, body, {.shape = body.shape});
        for (const Part& part : body.parts) attach(b, body, part);
    }

    static void set_mass(dBodyID b, const Body& body) {
        dMass mass;
        const V3 inertia = solid_of(body.shape).inertia * body.mass;
        dMassSetParameters(&mass, body.mass, 0, 0, 0, inertia.x, inertia.y, inertia.z, 0, 0, 0);
        dBodySetMass(b, &mass);
    }

    /// Attaches a shape to the last body, or to the world if `b` is null.
    void attach(dBodyID b, const Body& body, const Part& part) {
        dGeomID geometry;
        if (part.shape.kind == Kind::plane) {
            const V3 n = rotate(body.rotation, {0, 1, 0});
            geometry = dCreatePlane(space, n.x, n.y, n.z, dot(n, body.position));
            dGeomSetData(geometry, reinterpret_cast<void*>(bodies.size() - 1));
            return;
        }
        geometry = geometry_of(part.shape);
        dGeomSetData(geometry, reinterpret_cast<void*>(bodies.size() - 1));
        const bool along_z = part.shape.kind == Kind::capsule || part.shape.kind == Kind::cylinder;
        const Turn own = along_z ? part.rotation * about({1, 0, 0}, -pi / 2) : part.rotation; // turns z to y
        const Turn q = b == nullptr ? body.rotation * own : own;
        const V3 at = b == nullptr ? body.position + rotate(body.rotation, part.position) : part.position;
        const dQuaternion turn = {q.w, q.x, q.y, q.z};
        if (b == nullptr) {
            dGeomSetPosition(geometry, at.x, at.y, at.z);
            dGeomSetQuaternion(geometry, turn);
            return;
        }
        dGeomSetBody(geometry, b);
        const bool is_moved = along_z || length(at) > 0 || std::abs(q.w) < 1;
        if (!is_moved) return; // a geometry without offset is cheaper
        dGeomSetOffsetPosition(geometry, at.x, at.y, at.z);
        dGeomSetOffsetQuaternion(geometry, turn);
    }

    void join(const Joint& joint) {
        const dBodyID a = joint.a < 0 ? nullptr : bodies[static_cast<std::size_t>(joint.a)];
        const dBodyID b = bodies[static_cast<std::size_t>(joint.b)];
        const V3 p = joint.anchor, x = joint.axis;
        const auto set = [&](dJointID made, void (*parameter)(dJointID, int, dReal)) {
            if (joint.limit != 0)
                parameter(made, dParamLoStop, -joint.limit), parameter(made, dParamHiStop, joint.limit);
            if (joint.motor_force != 0)
                parameter(made, dParamVel, joint.motor_speed), parameter(made, dParamFMax, joint.motor_force);
        };
        if (joint.kind == Link::ball) {
            const dJointID made = dJointCreateBall(world, nullptr);
            dJointAttach(made, b, a);
            dJointSetBallAnchor(made, p.x, p.y, p.z);
        } else if (joint.kind == Link::hinge) {
            const dJointID made = dJointCreateHinge(world, nullptr);
            dJointAttach(made, b, a);
            dJointSetHingeAnchor(made, p.x, p.y, p.z);
            dJointSetHingeAxis(made, x.x, x.y, x.z);
            set(made, dJointSetHingeParam);
        } else {
            const dJointID made = dJointCreateSlider(world, nullptr);
            dJointAttach(made, b, a);
            dJointSetSliderAxis(made, x.x, x.y, x.z);
            set(made, dJointSetSliderParam);
        }
    }

    void attract() {
        for (dBodyID b : bodies) {
            if (b == nullptr) continue;
            dMass mass;
            dBodyGetMass(b, &mass);
            const dReal* at = dBodyGetPosition(b);
            const V3 p{at[0], at[1], at[2]};
            const double r = length(p);
            const V3 force = p * (-scene.attraction * mass.mass / (r * r * r));
            dBodyAddForce(b, force.x, force.y, force.z);
        }
    }

    Scene scene;
    int steps;
    double step_time;
    dWorldID world;
    dSpaceID space;
    dJointGroupID contacts;
    std::deque<Convex> convex;
    std::deque<Mesh> meshes;
    std::vector<dBodyID> bodies;
};

} // namespace

std::unique_ptr<Engine> make_ode(const Contestant& contestant, const Scene& scene) {
    return std::make_unique<Ode>(contestant, scene);
}

} // namespace engines
#endif
