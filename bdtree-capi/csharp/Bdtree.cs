// bdtree for C# (.NET Standard 2.0, C# 7.3, so Unity and mono): P/Invoke of bdtree.h, owners of its handles, arrays, and
// exceptions in place of statuses. Methods call the function of bdtree.h of the same name (without the name of what they
// are members of), whose comment says units, frames, errors and which threads may call it. Put all files of this folder
// into the project and libbdtree.so beside them.
//
// All functions of bdtree.h are here. The language has its own form of these:
// - *_new, *_free: constructors and Dispose; bdt_instance_new_with_cache is a constructor with two sizes more.
// - *_each: a Func takes the items: see Workspace.ContactsEach.
// - bdt_instance_set_pose_with_joints, bdt_instance_set_skeleton_pose: overloads of Instance.SetPose.
// - Truncated is not seen: arrays and strings grow. Stopped is the answer false of *Each.
// - bdt_ball and others, bdt_transform_after, bdt_joint_in_model: members of Shape and Transform.
using System;
using System.Runtime.InteropServices;
using System.Text;

namespace Bdtree
{
    /// <summary>What a function of bdtree.h returned, and what it says.</summary>
    public sealed class BdtreeException : Exception
    {
        public readonly Status Status;

        internal BdtreeException(Status status, string text) : base(text) { Status = status; }
    }

    public enum Status
    {
        Ok = 0, Truncated = 1, Stopped = 2, ErrorNull = -1, ErrorHandle = -2, ErrorBusy = -3, ErrorArgument = -4,
        ErrorLength = -5, ErrorIndex = -6, ErrorIo = -7, ErrorFormat = -8, ErrorPose = -9, ErrorNoSkin = -10,
        ErrorNoAnimation = -11, ErrorDynamics = -12, ErrorStep = -13, ErrorState = -14, ErrorPanic = -15,
    }

    /// <summary>The library itself.</summary>
    public static class Library
    {
        /// <summary>In place of a number where there is none.</summary>
        public const uint None = uint.MaxValue;

        /// <summary>major · 10^6 + minor · 10^3 + patch.</summary>
        public static uint Version { get { return Native.bdt_version(); } }

        public static string VersionText { get { return Marshal.PtrToStringAnsi(Native.bdt_version_text()); } }

        /// <summary>Whether the library knows which handles live.</summary>
        public static bool ChecksHandles { get { return Native.bdt_checks_handles() != 0; } }

        /// <summary>What a status means, in a few words.</summary>
        public static string StatusText(Status status)
        {
            return Marshal.PtrToStringAnsi(Native.bdt_status_text((int)status));
        }

        /// <summary>What went wrong in this thread's last call that returned an error; empty before the first.</summary>
        public static string LastError { get { return Owned.Text(Native.bdt_last_error); } }
    }

    /// <summary>A handle that is freed with its owner.</summary>
    public abstract class Owned : SafeHandle
    {
        protected Owned() : base(IntPtr.Zero, true) { }

        public override bool IsInvalid { get { return handle == IntPtr.Zero; } }

        /// <summary>Takes what a function has made.</summary>
        internal void Own(Status status, IntPtr made)
        {
            Native.Check(status);
            SetHandle(made);
        }

        internal delegate Status AskFor<T>(T[] items, UIntPtr capacity, out UIntPtr count);

        /// <summary>All items of an answer.</summary>
        internal static T[] All<T>(AskFor<T> ask) { return Grown(ask, 0); }

        internal static string Text(AskFor<byte> ask) { return Encoding.UTF8.GetString(Grown(ask, 1)); }

        /// <summary>All items; arrays that are too short grow, and have room for what closes a text.</summary>
        private static T[] Grown<T>(AskFor<T> ask, int closing)
        {
            T[] items = new T[32];
            UIntPtr count;
            while (Native.Check(ask(items, Length(items), out count)) == Status.Truncated)
                items = new T[(int)count + closing];
            Array.Resize(ref items, (int)count);
            return items;
        }

        internal static UIntPtr Length(Array array) { return (UIntPtr)array.Length; }
    }
}
