/* See CoreMinimal.h. */
#pragma once

#include "CoreMinimal.h"

#define GENERATED_BODY() using Super = UActorComponent;

enum ELevelTick { LEVELTICK_All };
enum ETickingGroup { TG_PostUpdateWork };
enum ERelativeTransformSpace { RTS_Component };

struct FActorComponentTickFunction {
    bool bCanEverTick;
    ETickingGroup TickGroup;
};

class AActor;

class UActorComponent
{
public:
    virtual ~UActorComponent() = default;
    virtual void BeginPlay();
    virtual void TickComponent(float DeltaTime, ELevelTick TickType, FActorComponentTickFunction *ThisTickFunction);
    AActor *GetOwner() const;
    FActorComponentTickFunction PrimaryComponentTick;
};
