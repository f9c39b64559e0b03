// What C calls: static functions, which IL2CPP asks for, with the object that takes the items as their context.
using System;
using System.Runtime.ExceptionServices;
using System.Runtime.InteropServices;

namespace Bdtree
{
    /// <summary>IL2CPP looks for this name at functions that C calls.</summary>
    [AttributeUsage(AttributeTargets.Method)]
    internal sealed class MonoPInvokeCallbackAttribute : Attribute
    {
        public MonoPInvokeCallbackAttribute(Type type) { }
    }

    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    internal delegate int OnContact(ref Contact contact, IntPtr context);

    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    internal delegate int OnHit(ref Hit hit, IntPtr context);

    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    internal delegate int OnPairContact(ref PairContact contact, IntPtr context);

    internal static class Callbacks
    {
        // They live as long as the program, so that C never calls one that was collected.
        internal static readonly OnContact Contact = Take;
        internal static readonly OnHit Hit = Take;
        internal static readonly OnPairContact PairContact = Take;

        [MonoPInvokeCallback(typeof(OnContact))]
        private static int Take(ref Contact contact, IntPtr context) { return Taker<Contact>.Take(contact, context); }

        [MonoPInvokeCallback(typeof(OnHit))]
        private static int Take(ref Hit hit, IntPtr context) { return Taker<Hit>.Take(hit, context); }

        [MonoPInvokeCallback(typeof(OnPairContact))]
        private static int Take(ref PairContact contact, IntPtr context)
        {
            return Taker<PairContact>.Take(contact, context);
        }
    }

    /// <summary>Hands items of a query to a Func, whose exceptions wait until the query has ended.</summary>
    internal sealed class Taker<T>
    {
        private Func<T, bool> take;
        private ExceptionDispatchInfo thrown;

        internal static int Take(T item, IntPtr context)
        {
            Taker<T> taker = (Taker<T>)GCHandle.FromIntPtr(context).Target;
            try
            {
                return taker.take(item) ? 0 : 1;
            }
            catch (Exception exception)
            {
                taker.thrown = ExceptionDispatchInfo.Capture(exception);
                return 1;
            }
        }

        /// <summary>Asks with the context of a callback; false if `take` has ended the query.</summary>
        internal static bool Each(Func<T, bool> take, Func<IntPtr, Status> ask)
        {
            Taker<T> taker = new Taker<T> { take = take };
            GCHandle context = GCHandle.Alloc(taker);
            try
            {
                Status status = ask(GCHandle.ToIntPtr(context));
                taker.thrown?.Throw();
                return Native.Check(status) != Status.Stopped;
            }
            finally
            {
                context.Free();
            }
        }
    }
}
