// Worlds.
using System;

namespace Bdtree
{
    /// <summary>Bodies that fall, touch and vibrate.</summary>
    public sealed class World : Owned
    {
        public World() : this(WorldOptions.Usual) { }

        public World(WorldOptions options)
        {
            Own(Native.bdt_world_new(ref options, out IntPtr made), made);
        }

        public uint AddModel(Model model) { return AddModel(model, BodyOptions.Usual); }

        public uint AddModel(Model model, BodyOptions options)
        {
            Native.Check(Native.bdt_world_add_model(this, model, ref options, out uint id));
            return id;
        }

        public void AddPlane(Plane plane) { Native.Check(Native.bdt_world_add_plane(this, ref plane)); }

        public uint AddBody(uint model, Transform at, BodyFrame frame = BodyFrame.Free)
        {
            Native.Check(Native.bdt_world_add_body(this, model, frame, ref at, out uint id));
            return id;
        }

        public StepReport Step()
        {
            Native.Check(Native.bdt_world_step(this, out StepReport report));
            return report;
        }

        public Counts Counts
        {
            get
            {
                Counts counts;
                Native.Check(Native.bdt_world_counts(this, out counts.Bodies, out counts.Asleep, out counts.Steps));
                return counts;
            }
        }

        public BodyState State(uint body)
        {
            Native.Check(Native.bdt_body_state(this, body, out BodyState state));
            return state;
        }

        public Transform Placement(uint body)
        {
            Native.Check(Native.bdt_body_placement(this, body, out Transform at));
            return at;
        }

        public int ModeCount(uint body)
        {
            Native.Check(Native.bdt_body_mode_count(this, body, out UIntPtr count));
            return (int)count;
        }

        public double[] Q(uint body)
        {
            double[] q = new double[ModeCount(body)];
            Native.Check(Native.bdt_body_q(this, body, q, null, Length(q)));
            return q;
        }

        /// <summary>How fast q changes (per second).</summary>
        public double[] Rate(uint body)
        {
            double[] rate = new double[ModeCount(body)];
            Native.Check(Native.bdt_body_q(this, body, null, rate, Length(rate)));
            return rate;
        }

        /// <summary>`q` and `rate`: as many numbers as the body has modes.</summary>
        public void SetModes(uint body, double[] q, double[] rate)
        {
            if (rate.Length != q.Length)
                throw new BdtreeException(Status.ErrorLength, "rate has another length than q");
            Native.Check(Native.bdt_body_set_modes(this, body, q, rate, Length(q)));
        }

        public void SetVelocity(uint body, Vec3 velocity, Vec3 angularVelocity)
        {
            Native.Check(Native.bdt_body_set_velocity(this, body, velocity, angularVelocity));
        }

        public void AddForce(uint body, Vec3 force, Vec3 torque)
        {
            Native.Check(Native.bdt_body_add_force(this, body, force, torque));
        }

        public void AddModalForce(uint body, double[] force)
        {
            Native.Check(Native.bdt_body_add_modal_force(this, body, force, Length(force)));
        }

        public void AddModalImpulse(uint body, double[] impulse)
        {
            Native.Check(Native.bdt_body_add_modal_impulse(this, body, impulse, Length(impulse)));
        }

        public void Drive(uint body, double[] q, Transform at)
        {
            Native.Check(Native.bdt_body_drive(this, body, q, Length(q), ref at));
        }

        public Event[] Events()
        {
            return All((Event[] items, UIntPtr capacity, out UIntPtr count) =>
                Native.bdt_world_events(this, items, capacity, out count));
        }

        public WorldContact[] Contacts()
        {
            return All((WorldContact[] items, UIntPtr capacity, out UIntPtr count) =>
                Native.bdt_world_contacts(this, items, capacity, out count));
        }

        public Energy Energy
        {
            get { Native.Check(Native.bdt_world_energy(this, out Energy energy)); return energy; }
        }

        public Momenta Momenta
        {
            get
            {
                Momenta momenta;
                Native.Check(Native.bdt_world_momenta(this, out momenta.Linear, out momenta.Angular));
                return momenta;
            }
        }

        public Hit CastRay(Ray ray)
        {
            Native.Check(Native.bdt_world_cast_ray(this, ref ray, out Hit hit));
            return hit;
        }

        /// <summary>Every triangle of every body that the shape touches; Body is the body.</summary>
        public Contact[] TouchedBy(Shape shape)
        {
            return All((Contact[] items, UIntPtr capacity, out UIntPtr count) =>
                Native.bdt_world_touched_by(this, ref shape, items, capacity, out count));
        }

        public byte[] Save()
        {
            return All((byte[] items, UIntPtr capacity, out UIntPtr count) =>
                Native.bdt_world_save(this, items, capacity, out count));
        }

        public void Restore(byte[] bytes) { Native.Check(Native.bdt_world_restore(this, bytes, Length(bytes))); }

        protected override bool ReleaseHandle() { return Native.bdt_world_free(handle) == Status.Ok; }
    }
}
