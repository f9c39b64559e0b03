## A ray down on a bending tube, in steps of a tenth of a second.
extends Node3D

@onready var collider: BdtCollider3D = $Collider


func _ready() -> void:
	var mesh: MeshInstance3D = $Tube.find_children("*", "MeshInstance3D")[0]
	collider.mesh_instance = collider.get_path_to(mesh)
	collider.failed.connect(func(kind, message): print("failed: ", kind, ": ", message))

	# At rest: triangle 216 at (2, 1.736168, 0).
	ask("rest")
	var player: AnimationPlayer = $Tube.find_children("*", "AnimationPlayer")[0]
	player.play("wave")
	for tenths in 10:
		player.seek(tenths * 0.1, true)
		ask("%.1f s" % (tenths * 0.1))


func ask(when: String) -> void:
	if not collider.update_pose():
		return
	var hit := collider.cast_ray(Vector3(2.0, 10.0, 0.0), Vector3(2.0, -10.0, 0.0))
	if hit.is_empty():
		print(when, ": nothing")
	else:
		print(when, ": triangle ", hit.triangle, " at ", hit.point, " on ", hit.bone)
