/* See CoreMinimal.h. */
#pragma once

#include "Components/ActorComponent.h"

class USkeletalMeshComponent : public UActorComponent
{
public:
    int32 GetBoneIndex(FName Bone) const;
    float GetMorphTarget(FName Name) const;
    FTransform GetSocketTransform(FName Name, ERelativeTransformSpace Space) const;
    const FTransform &GetComponentTransform() const;
};
