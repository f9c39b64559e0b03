/* See CoreMinimal.h. */
#pragma once

#include "CoreMinimal.h"

struct FPaths {
    static FString ProjectContentDir();
    static FString Combine(const FString &First, const FString &Second);
};
