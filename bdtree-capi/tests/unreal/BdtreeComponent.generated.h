/* Unreal writes a file of this name from the component's header. */
#pragma once
