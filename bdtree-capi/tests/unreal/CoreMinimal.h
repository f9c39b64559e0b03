/*
 * What docs/guide/unreal.md uses of Unreal 5, declared so that its component can be compiled where there is no Unreal.
 * Nothing of it runs.
 */
#pragma once

#include <cstdint>

// Unreal has macros of these names; the page's header has to cope.
#define check(expr) static_assert(false, "Unreal's macro, in a header of bdtree")
#define verify(expr) static_assert(false, "Unreal's macro, in a header of bdtree")

#define UCLASS(...)
#define UPROPERTY(...)
#define UFUNCTION(...)
#define TEXT(x) u##x
#define UTF8_TO_TCHAR(x) FUTF8ToTCHAR(x).Get()
#define UE_LOG(category, verbosity, format, ...) Log(format, __VA_ARGS__)
#define INDEX_NONE (-1)

using int32 = std::int32_t;
using uint32 = std::uint32_t;
using uint8 = std::uint8_t;
using TCHAR = char16_t;

void Log(const TCHAR *Format, ...);

struct FUTF8ToTCHAR {
    explicit FUTF8ToTCHAR(const char *Text);
    const TCHAR *Get() const;
};

struct FString {
    const TCHAR *operator*() const;
};

struct FName {
    FName();
    explicit FName(const TCHAR *Name);
    FString ToString() const;
};

template <class T> struct TArray {
    void Add(const T &Item);
    T &Last();
    T &operator[](int32 Index);
    int32 Num() const;
    T *GetData();
};

struct FVector {
    double X, Y, Z;
    FVector(double InX, double InY, double InZ);
    FVector operator-(const FVector &Other) const;
    double Size() const;
    bool IsZero() const;
};

struct FQuat {
    double X, Y, Z, W;
};

struct FTransform {
    FVector GetTranslation() const;
    FQuat GetRotation() const;
    FVector GetScale3D() const;
};
