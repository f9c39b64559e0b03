// What docs/guide/unreal.md uses of Unreal's build tool, declared so that its modules can be compiled where there is none.
using System.Collections.Generic;

namespace UnrealBuildTool
{
    public struct UnrealTargetPlatform
    {
        public static readonly UnrealTargetPlatform Linux = new UnrealTargetPlatform { number = 1 };
        public static readonly UnrealTargetPlatform Win64 = new UnrealTargetPlatform { number = 2 };
        private int number;

        public static bool operator ==(UnrealTargetPlatform a, UnrealTargetPlatform b) { return a.number == b.number; }
        public static bool operator !=(UnrealTargetPlatform a, UnrealTargetPlatform b) { return a.number != b.number; }
        public override bool Equals(object other) { return other is UnrealTargetPlatform && this == (UnrealTargetPlatform)other; }
        public override int GetHashCode() { return number; }
    }

    public class ReadOnlyTargetRules
    {
        public UnrealTargetPlatform Platform { get { return UnrealTargetPlatform.Linux; } }
    }

    public class ModuleRules
    {
        public enum ModuleType { CPlusPlus, External }
        public enum PCHUsageMode { Default, UseExplicitOrSharedPCHs }

        public ModuleRules(ReadOnlyTargetRules target) { }

        public ModuleType Type { get; set; }
        public PCHUsageMode PCHUsage { get; set; }
        public bool bEnableExceptions { get; set; }
        public string ModuleDirectory { get { return "."; } }
        public List<string> PublicSystemIncludePaths = new List<string>();
        public List<string> PublicAdditionalLibraries = new List<string>();
        public List<string> PublicSystemLibraries = new List<string>();
        public List<string> PublicDependencyModuleNames = new List<string>();
    }
}
